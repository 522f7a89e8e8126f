"""Writes what the example `twins` prints into BENCHMARKS.md."""

import os
import pathlib
import re
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import twins  # noqa: E402
from section import processor, write_section  # noqa: E402

HEAD = """## The processor beside the graphics device

`bench/draw/run` on {machine}. Levels of detail off, four samples a pixel on both. Milliseconds of a frame: the median of 21, the
best, the processor time of all threads together, and times the first column's median. The load of the machine was {load:.1f} when
it began; where that is more than 0, ratios and the best say more than medians. Each effect (docs/looks.md) is drawn beside the shadow of
*one shape* alone; the last two rows are whole looks. Aims on 2 cores: 25 ms for the gallery, 12 for one shape, 25 for the large one.
"""

FLOOR = """**The floor.** A frame without shadow cannot take less than its arithmetic and its memory. Counted in the sources
(`cpu/project.rs`, `fill.rs`, `batch.rs`, `shade.rs`): {flops[0]} operations a vertex, {flops[1]} a triangle, {flops[2]} more a triangle
that faces the viewer (half of them), {flops[3]} a pixel that shows a surface; {sizes[0]} bytes a vertex, {sizes[1]} a triangle, {sizes[2]} a
pixel of the picture. In the same run NumPy multiplied matrices at {rate:.0f} Gflop/s and copied {copied:.1f} GB/s on all cores: what
both take one after the other is the floor.
"""
# Operations of projecting a vertex; of sorting a triangle; of setting up one that faces the viewer; of testing four samples
# of a pixel, placing and lighting it.
FLOPS = (32, 8, 100, 840)
# A vertex is read with its normal, and its corner written; a triangle is read twice; a pixel painted and lit.
SIZES = (36, 24, 8)


def rates():
    """What this machine does at most: Gflop/s of a matrix product, GB/s of a copy."""
    import numpy

    def best(work):
        times = []
        for _ in range(7):
            start = time.perf_counter()
            work()
            times.append(time.perf_counter() - start)
        return min(times)

    n = 1536
    a, b = (numpy.random.default_rng(i).random((n, n), dtype=numpy.float32) for i in range(2))
    out, big = numpy.empty_like(a), numpy.ones(2**24, dtype=numpy.float32)
    copy = numpy.empty_like(big)
    flops = 2 * n**3 / best(lambda: numpy.matmul(a, b, out=out))
    # A copy reads and writes.
    return flops / 1e9, 2 * big.nbytes / best(lambda: numpy.copyto(copy, big)) / 1e9


def floor(counts, table):
    """The section's part on what a frame costs at least."""
    try:
        rate, copied = rates()
    except ImportError:
        return "The floor was not computed: this Python has no NumPy (PEERS_PYTHON names another)."
    lines = [FLOOR.format(flops=FLOPS, sizes=SIZES, rate=rate, copied=copied)]
    lines += ["| scene | vertices | triangles | pixels | Mflop | MB | floor, ms | reached, ms | share |", "|" + "---|" * 9]
    for line in counts:
        name, *numbers = re.match(r"counts: (.*), (\d+) vertices, (\d+) triangles, (\d+) of (\d+)x(\d+)", line).groups()
        vertices, triangles, pixels, width, height = map(int, numbers)
        flop = sum(f * n for f, n in zip(FLOPS, (vertices, triangles, triangles / 2, pixels)))
        size = sum(s * n for s, n in zip(SIZES, (vertices, triangles, width * height)))
        least = flop / rate / 1e6 + size / copied / 1e6
        row = next(row for row in table if row.startswith(f"| {name} ") and "| no shadow |" in row)
        reached = float(re.search(r"best ([\d.]+)", row).group(1))
        lines.append(
            f"| {name} | {vertices:,} | {triangles:,} | {pixels:,} | {flop / 1e6:.0f} | {size / 1e6:.0f} "
            f"| {least:.1f} | {reached:.1f} | {100 * least / reached:.0f} % |"
        )
    return "\n".join(lines)


def main():
    load = os.getloadavg()[0]
    done = subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True)
    devices, counts, table = twins.read(done.stdout)
    said = "Columns: " + "; ".join(devices) + "."
    text = "\n".join([HEAD.format(machine=processor(), load=load), said, "", *table, "", floor(counts, table)])
    write_section("draw", text)
    print(done.stdout, end="")


if __name__ == "__main__":
    main()
