"""Writes the rows of `chladni-bench keeping` into BENCHMARKS.md."""

import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import processor, write_section


def means(rows):
    """A sentence: how much of the movement is kept in the mean, of each model."""
    kept = {}
    for row in rows.strip().splitlines():
        cells = [cell.strip() for cell in row.strip("| ").split("|")]
        kept.setdefault(cells[3], []).append(min(100.0, float(cells[8])))
    each = ", ".join(f"{sum(k) / len(k):.0f} % in the {model} model" for model, k in kept.items())
    every = [share for shares in kept.values() for share in shares]
    much = sum(share >= 70 for share in every)
    return (
        f"In the mean of these {len(every)} rows {sum(every) / len(every):.0f} % of the movement is kept ({each}; more than 100 % "
        f"counts as 100), in {much} of them 70 % or more."
    )


rows = pathlib.Path(sys.argv[1]).read_text()
text = f"""## Keeping triangles

{processor()}, load average {os.getloadavg()[0]:.1f} at the end. Made by `bench/keeping/run`; K = 512. Shares of the triangles in
percent: folded and newly crossing without the limit, and with it; what is kept is the mean length of the displacement. Seconds
are of the search that runs beside the window whenever the hand rests.

| shape | template | μ | model | folded | crossing | folded, kept | crossing, kept | movement kept, % | s |
|---|---|---|---|---|---|---|---|---|---|
{rows}
{means(rows)}"""
write_section("keeping", text)
