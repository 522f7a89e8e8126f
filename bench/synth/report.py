"""Writes the measurements of bench/synth/run into BENCHMARKS.md, between the synth markers.

Usage: report.py FOLDER THREADS
"""

import json
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import processor, write_section

folder, threads = pathlib.Path(sys.argv[1]), sys.argv[2]
rows = json.loads((folder / "rows.json").read_text())
avx2 = json.loads((folder / "avx2.json").read_text())
products = [json.loads(line) for line in (folder / "product.jsonl").read_text().splitlines()]
numpy = {
    (p["vertices"], p["harmonics"], p["columns"]): p["numpy_ms"]
    for p in map(json.loads, (folder / "numpy.jsonl").read_text().splitlines())
}


drawn_by = ", ".join(sorted({r["drawn_by"] for r in rows if r["drawn_by"]})) or "nothing"
load = pathlib.Path("/proc/loadavg").read_text().split()[0]
lines = [
    "## Synthesis and drawing",
    "",
    f"{processor()}, {threads} threads; devices: {', '.join(sorted({r['device'] for r in rows}))}; drawn by {drawn_by}. "
    f"Load average at the end of the run: {load} (above {threads}, others were using the machine too: times are upper bounds, and OpenBLAS, whose threads spin, suffers most). "
    "Made by `bench/synth/run`.",
    "",
    "Shapes are generated: a bumpy sphere of exactly n vertices with K smooth functions on it, which are not its "
    "harmonics but cost the same. All K have weight; every item has its own coefficients in vector form. Times are "
    "medians. Drawing is 1024×768 in S cells, as films are drawn; on a CPU row it includes the upload to a card, and what a "
    "software device deforms is not drawn. *fps* is of synthesis and normals, "
    "*drawn* of all three. The published rates (GeForce GT 130 / 9600M) include drawing. *Bandwidth*: bytes of basis read and positions written per "
    "second of synthesis, over those of a copy of the basis in the same run.",
    "",
    "| model | n | K | S | backend | synthesis ms | normals ms | drawing ms | fps | drawn | published | MB moved | bandwidth |",
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
]
for r in rows:
    draw = "" if r["draw_ms"] is None else f"{r['draw_ms']:.1f}"
    drawn = "" if r["drawn_fps"] is None else f"{r['drawn_fps']:.1f}"
    published = "" if r["published_fps"] is None else f"{r['published_fps']:.1f}"
    lines.append(
        f"| {r['model']} | {r['vertices']:,} | {r['harmonics']:,} | {r['items']} | {r['backend']} | {r['synthesis_ms']:.2f} "
        f"| {r['normals_ms']:.2f} | {draw} | {r['fps']:.1f} | {drawn} | {published} | {r['bytes_moved'] / 1e6:.1f} "
        f"| {100 * r['bandwidth_share']:.0f} % |"
    )
if avx2:
    lines += ["", "Positions on AVX2, S = 12:", "", "| model | n | K | synthesis ms |", "|---|---|---|---|"]
    lines += [f"| {r['model']} | {r['vertices']:,} | {r['harmonics']:,} | {r['synthesis_ms']:.2f} |" for r in avx2]
lines += [
    "",
    "The product alone (ours includes adding the rest shape), against the `gemm` crate in the same process and NumPy "
    "with OpenBLAS right after, both f32:",
    "",
    "| n | K | columns | chladni ms | gemm ms | NumPy ms | times gemm | times NumPy |",
    "|---|---|---|---|---|---|---|---|",
]
for p in products:
    n, k, c, ours, gemm = p["vertices"], p["harmonics"], p["columns"], p["chladni_ms"], p["gemm_ms"]
    theirs = numpy[n, k, c]
    lines.append(
        f"| {n:,} | {k:,} | {c} | {ours:.2f} | {gemm:.2f} | {theirs:.2f} | {gemm / ours:.1f} | {theirs / ours:.1f} |"
    )

write_section("synth", "\n".join(lines))
