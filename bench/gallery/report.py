"""Writes what `chladni-bench gallery` measured into BENCHMARKS.md."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

rows = "\n".join(
    f"| {row['shape']} | {row['vertices']} | {row['random']:.2f} | {row['first']:.2f} | {row['bred']:.2f} "
    f"| {100 * row['folded']:.2f} | {100 * row['moved']:.1f} | {row['secs']:.1f} |"
    for row in json.loads(pathlib.Path(sys.argv[1]).read_text())
)
text = f"""## Galleries of caricatures

{machine()}. Made by `bench/gallery/run`; K = 512, the mean of five seeds. The least distance of two of twelve, each made as large
as the other, as a share of what they move (0: the same but for their size): of random ones, of the first gallery, and of the
children of three of it. Folded is the largest share of triangles of any caricature (limit 0.5 %), moved the mean movement as a
share of the size, seconds those until twelve children are there: upper bounds where
the machine is busy.

| shape | vertices | random | first | bred | folded, % | moved, % | s |
|---|---|---|---|---|---|---|---|
{rows}
"""
write_section("gallery", text)
