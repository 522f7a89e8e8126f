"""Writes the section of BENCHMARKS.md on closest points. Called by bench/trees/run."""

import pathlib
import subprocess
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

trees, *meshes = sys.argv[1:]
lines = ["## Closest points", "", f"{machine()}. Made by `bench/trees/run`: our tree of boxes beside parry's BVH, both in double precision "
         "on one thread, alternating in one run, medians of seven; distances agree within 1e-9. *Times*: parry's over ours.", ""]
for mesh in meshes:
    measured = subprocess.run([trees, mesh], check=True, capture_output=True, text=True).stdout
    lines += [f"`{pathlib.Path(mesh).name}`: {measured.strip()}", ""]
write_section("trees", "\n".join(lines).rstrip())
print("\n".join(lines))
