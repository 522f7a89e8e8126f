"""Our solver beside SLEPc on ranks of this machine; see `run`."""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section  # noqa: E402
from torus import torus  # noqa: E402

CHLADNI = os.environ["CHLADNI"]
K = 64
THREADS = 2
# Ranks and factors; without factors, conjugate gradients solve.
RANKS = [(1, 1), (2, 1), (2, 2), (4, 1), (4, 4), (1, 0), (2, 0), (4, 0)]
# Vertices in the two directions of a torus, and on which ranks they are solved; the last one is for the model alone.
QUICK = [((80, 50), RANKS)]
MESHES = [((100, 50), RANKS), ((200, 100), [(1, 1), (2, 2), (1, 0), (2, 0)])]
MODELED = [10e6, 50e6, 200e6]


def basis(mesh, *more):
    """What --json prints, the eigenvalues, and the seconds of the whole command."""
    with tempfile.NamedTemporaryFile(suffix=".npz") as out:
        command = [CHLADNI, "--quiet", "basis", str(mesh), "-k", str(K), "--no-cache", "--json", "-o", out.name, *more]
        start = time.perf_counter()
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        seconds = time.perf_counter() - start
        return json.loads(done.stdout), np.load(out.name)["eigenvalues"], seconds


def measure(meshes):
    rows, factors = [], []
    with tempfile.TemporaryDirectory() as folder:
        for (m, n), configurations in meshes:
            mesh = pathlib.Path(folder) / f"{m}x{n}.ply"
            torus(m, n, mesh)
            _, own, usual = basis(mesh, "--threads", str(THREADS))
            rows.append(f"| {m * n:,} | ours, {THREADS} threads | 1 | | | | | |")
            for ranks, groups in configurations:
                inner = ["--groups", str(groups)] if groups else ["--iterative"]
                report, values, seconds = basis(mesh, "--engine", "slepc", "--ranks", str(ranks), *inner)
                on, spent = report["ranks"], report["ranks"]["seconds"]
                off = np.abs(values[1:] / own[1:] - 1).max()
                counts = {True: "match", False: "**do not match**", None: "none"}[report["inertia_counts_match"]]
                peak = max(on["peak_bytes"]) / 1e6
                rows.append(
                    f"| {m * n:,} | {ranks} ranks, {groups or 'no'} factors | {seconds / usual:.1f} | "
                    f"{spent['count']:.1f} + {spent['solve']:.1f} + {spent['polish']:.1f} | {peak:.0f} | {off:.1e} | "
                    f"{report['max_relative_residual']:.1e}, {report['max_orthogonality_error']:.1e} | {counts} |"
                )
                print(rows[-1], flush=True)
                if (ranks, groups) == (1, 1):
                    factors.append((m * n, on["factor_entries"], on["factor_flops"], max(on["peak_bytes"])))
    return rows, factors


def model(factors):
    """Lines on what more vertices take, from the largest mesh that was measured."""
    n, entries, flops, peak = factors[-1]
    fill, work = entries / (n * math.log2(n)), flops / n**1.5
    # What a rank holds besides its vectors, per value of the factor; the interpreter and its libraries take 80 MB.
    vectors = 8 * n * (2 * 64 + K)
    share = (peak - 80e6 - vectors) / entries
    lines = [
        f"A factor of n vertices has {fill:.1f} n log₂ n values and takes {work:.0f} n^1.5 additions and multiplications",
        "(" + ", ".join(f"{e / (v * math.log2(v)):.1f} and {f / v**1.5:.0f} at {v:,}" for v, e, f, _ in factors) + ");",
        f"all memory of a rank besides its vectors comes to {share:.0f} bytes for each, an upper estimate, as part of it grows with n",
        "only. So, for K = 256 on 64 ranks with one factor:",
        "",
        "| vertices | values of a factor | memory of all ranks | a rank | factoring | moved in it | harmonics |",
        "|---|---|---|---|---|---|---|",
    ]
    for v in MODELED:
        values = fill * v * math.log2(v)
        everywhere = share * values + 8 * v * (2 * 64 + 256)
        lines.append(
            f"| {v / 1e6:.0f} million | {values / 1e9:.1f} · 10⁹ | {everywhere / 1e9:,.0f} GB | {everywhere / 64e9:.1f} GB | "
            f"{work * v**1.5 / 1e12:,.0f} Tflop | about {8 * v * 8 / 1e9:.1f} GB | {8 * 256 * v / 1e9:.0f} GB |"
        )
    return lines


def main():
    rows, factors = measure(QUICK if "--quick" in sys.argv else MESHES)
    if "--quick" in sys.argv:
        print("\n".join([*rows, *model(factors)]))
        return
    text = [
        "## Ranks",
        "",
        f"`basis -k {K}` of bumpy tori by our solver and by `--engine slepc`, made by `bench/ranks/run` on {machine()}. Ranks",
        "share these cores, and those of one factor wait for each other at each of its fronts: this shows that the results are",
        "the same and what ranks cost, not what they gain. Seconds are those of rank 0: counting (without factors: searching",
        "again), Krylov–Schur, polishing.",
        "",
        "| vertices | solver | time ÷ ours | seconds | MB a rank | λ off ours | residual, orthogonality | counts |",
        "|---|---|---|---|---|---|---|---|",
        *rows,
        "",
        *model(factors),
        "",
        "How this is modeled, with sources: docs/scale.md.",
    ]
    write_section("ranks", "\n".join(text))


main()
