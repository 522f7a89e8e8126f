"""Harmonics that do not fit in memory: `basis` of bumpy tori with and without room, and what comes of them streamed by NumPy.

usage: bench/basis/large.py [--quick]     (writes its section of BENCHMARKS.md; --quick prints small cases only)

CHLADNI   the program (default: target/release/chladni)
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np

try:
    import chladni
except ImportError:
    chladni = None

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section  # noqa: E402
from torus import torus  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHLADNI = os.environ.get("CHLADNI", str(ROOT / "target/release/chladni"))
# Vertices in the two directions, K, and the memory in GB that the solve may take; None is what is free.
QUICK = [((200, 150), 256, None), ((200, 150), 256, 0.15)]
CASES = [((1000, 800), 256, None), ((1000, 800), 256, 4), ((2000, 1500), 512, 16)]
# Harmonics that are in memory at once while they are streamed.
CHUNK = 32


def own_memory(pid):
    """Bytes of a process that are its own, without files that are mapped."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
        return 1024 * int(next(line for line in status.splitlines() if line.startswith("RssAnon")).split()[1])
    except (OSError, StopIteration):
        return 0


def solve(mesh, harmonics, memory, out):
    """What --json prints, the warning, seconds of the whole command, and the most memory that it had of its own."""
    limit = [] if memory is None else ["--memory", str(memory)]
    usual = ["basis", str(mesh), "-k", str(harmonics), "--no-cache", "--json", "-o", f"{out}/"]
    start, peak = time.perf_counter(), 0
    with subprocess.Popen([CHLADNI, "--quiet", *usual, *limit], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        output = []
        reader = threading.Thread(target=lambda: output.extend(process.communicate()))
        reader.start()
        while reader.is_alive():
            peak = max(peak, own_memory(process.pid))
            reader.join(0.1)
    if process.returncode:
        sys.exit(output[1].decode())
    return json.loads(output[0]), output[1].decode().strip(), time.perf_counter() - start, peak


def stream(folder):
    """Seconds in which a signal is taken apart and put together again, a few harmonics at a time, and the error."""
    start = time.perf_counter()
    columns = np.load(folder / "eigenvectors.npy", mmap_mode="r")
    mass = np.load(folder / "mass.npy")
    wanted = np.random.default_rng(1).standard_normal(columns.shape[1])
    signal, back = np.zeros(len(mass)), np.empty_like(wanted)
    for first in range(0, len(wanted), CHUNK):
        some = slice(first, first + CHUNK)
        signal += columns[:, some] @ wanted[some]
    for first in range(0, len(wanted), CHUNK):
        some = slice(first, first + CHUNK)
        back[some] = columns[:, some].T @ (mass * signal)
    return time.perf_counter() - start, np.abs(back - wanted).max()


def stream_here(folder):
    """The same by the package, if it is installed."""
    if chladni is None:
        return "not installed"
    start = time.perf_counter()
    basis = chladni.StoredBasis(folder)
    wanted = np.random.default_rng(1).standard_normal(len(basis.eigenvalues))
    error = np.abs(basis.analyze(basis.synthesize(wanted)) - wanted).max()
    return f"{time.perf_counter() - start:.1f} s, {error:.0e}"


def main():
    quick = "--quick" in sys.argv[1:]
    lines = [
        "## Harmonics that do not fit in memory",
        "",
        f"`bench/basis/large.py`, bumpy tori, on {machine()}. Memory is the most that the process had of its own; pages of the",
        "scratch file, which the system writes out when it needs room, are not its own. Streamed: NumPy sums all harmonics with random",
        f"coefficients and takes the sum apart again, {CHUNK} harmonics at a time from the mapped file; beside it the same by",
        "`chladni.StoredBasis`, which reads 1 MiB at a time in each thread; and the largest error of a coefficient.",
        "",
        "| vertices | K | harmonics take | `--memory` | own memory | seconds | residual, orthogonality | NumPy | `StoredBasis` |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory(dir="/var/tmp") as temporary:
        folder = pathlib.Path(temporary)
        for (m, n), harmonics, memory in QUICK if quick else CASES:
            mesh = folder / f"{m}x{n}.ply"
            torus(m, n, mesh)
            report, warning, seconds, peak = solve(mesh, harmonics, memory, folder / "out")
            streamed, error = stream(folder / "out")
            lines.append(
                f"| {m * n:,} | {harmonics} | {8e-9 * m * n * harmonics:.1f} GB | {f'{memory} GB' if memory else 'all that is free'} | "
                f"{peak / 1e9:.1f} GB | {seconds:.0f} | "
                f"{report['max_relative_residual']:.1e}, {report['max_orthogonality_error']:.1e} | {streamed:.1f} s, {error:.0e} | {stream_here(folder / 'out')} |"
            )
            print(lines[-1], warning, sep="\n", flush=True)
    if not quick:
        write_section("large", "\n".join(lines))


main()
