"""Writes the rows of `chladni-bench keeping` into BENCHMARKS.md."""

import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import processor, write_section

text = f"""## Keeping triangles

{processor()}, load average {os.getloadavg()[0]:.1f} at the end. Made by `bench/keeping/run`; K = 512. Shares of the triangles in
percent: folded and newly crossing without the limit, and with it; what is kept is the mean length of the displacement. Seconds
are of the search that runs beside the window whenever the hand rests.

| shape | template | μ | model | folded | crossing | folded, kept | crossing, kept | movement kept, % | s |
|---|---|---|---|---|---|---|---|---|---|
{pathlib.Path(sys.argv[1]).read_text()}"""
write_section("keeping", text)
