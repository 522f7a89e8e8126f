#!/usr/bin/env python3
"""Where the time of `basis` goes for the sizes that are asked for most, and the section of BENCHMARKS.md on it.

usage: bench/basis/shares.py [--write]     after `cargo build --release`; needs NumPy

On one thread, so that the parts add up to the whole, and the whole on all cores beside it; the median of three runs each.
"""

import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here.parent))
from section import machine, write_section  # noqa: E402
from torus import torus  # noqa: E402

TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", here.parents[1] / "target"))
# Vertices in the two directions of a bumpy torus.
MESHES = [(100, 50), (200, 100), (320, 160)]
HARMONICS = [64, 150, 300]
RUNS = 3
PARTS = {
    "operator": lambda report: report["seconds"]["operator"],
    "ordering": lambda report: report["profile"]["analyze"],
    "factors": lambda report: report["profile"]["factor"],
    "solves": lambda report: report["profile"]["solve"],
    "Lanczos": lambda report: sum(report["profile"][part] for part in ("orthogonalize", "project", "vectors")),
    "certificate": lambda report: report["profile"]["assemble"],
}


def median_run(mesh, k, *more):
    """What --json prints of the run whose whole takes the median of the time."""
    command = [TARGET / "release" / "chladni", "--quiet", "basis", str(mesh), "-k", str(k), "--no-cache", "--json", *more]
    reports = [json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout) for _ in range(RUNS)]
    return sorted(reports, key=lambda report: report["seconds"]["total"])[RUNS // 2]


def main():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for (m, n), k in itertools.product(MESHES, HARMONICS):
            mesh = pathlib.Path(folder) / f"{m}x{n}.ply"
            torus(m, n, mesh)
            report, everywhere = median_run(mesh, k, "--threads", "1"), median_run(mesh, k)
            total = report["seconds"]["total"]
            shares = [100 * part(report) / total for part in PARTS.values()]
            cells = " | ".join(f"{share:.0f}" for share in [*shares, 100 - sum(shares)])
            seconds = f"{total:.2f} | {everywhere['seconds']['total']:.2f}"
            rows.append(f"| {report['vertices']:,} | {k} | {seconds} | {cells} |")
            print(rows[-1], flush=True)
    text = [
        "## Where the time of a basis goes",
        "",
        f"Per cent of `basis --threads 1` of bumpy tori, median of {RUNS} runs, made by `bench/basis/shares.py --write` on {machine()}.",
        "Solves are triangular, with the factors; Lanczos is orthogonalization, projection and vectors; the certificate",
        "includes writing the vectors in the mesh's order. Beside the seconds on one thread stand those on all cores.",
        "",
        f"| vertices | K | s | s, all cores | {' | '.join(PARTS)} | rest |",
        "|---|---|---|---|" + "---|" * (len(PARTS) + 1),
        *rows,
    ]
    if "--write" in sys.argv:
        write_section("shares", "\n".join(text))


main()
