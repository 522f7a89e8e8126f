"""Writes the section of BENCHMARKS.md from what `chladni-bench tables` printed."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

# The caricature paper's Table 1, in the order of `run`: model, template, vertices, H_k and X̃ in seconds, frames a second.
CARICATURE = [
    ("Face 1", "Face 3", "49k", 429, 4.4, 8.6),
    ("Simple", "Ellipsoid", "50k", 422, 3.8, 8.5),
    ("Face 2", "Simple", "33k", 217, 2.5, 8.8),
    ("Lion", "Beethoven", "30k", 171, 1.1, 12.1),
    ("Face 3", "Dog", "36k", 191, 1.7, 10.6),
    ("Planck", "Egea", "49k", 402, 3.9, 9.0),
    ("Egea", "Planck", "31k", 183, 2.4, 9.6),
]
# The music paper's Table 1: model, vertices, K, seconds, frames a second with 1 (its CPU), 6 and 12 (its GPU) items.
MUSIC = [
    ("heart", 622, 256, 4, (99.7, 322.1, 203.7)),
    ("duck", 2108, 256, 7, (52.7, 208.3, 123.9)),
    ("spring", 4695, 256, 116, (12.7, 71.4, 41.4)),
    ("dinosaur", 14054, 533, 76, (4.7, 28.3, 13.9)),
    ("alien", 24988, 540, 235, (3.4, 22.4, 12.1)),
    ("blooby", 42432, 1065, 558, (1.5, 12.5, 7.5)),
    ("cow", 97803, 256, 1082, (0.1, 9.1, 3.1)),
]


def short(name):
    return pathlib.Path(name).stem


def caricature(rows):
    lines = [
        "| paper | n | H_k s | X̃ s | fps | ours | n | H_k s | match s | X̃ s | picking | painting | filters (χ alone) "
        "| synthesis | normals | drawing | fps |",
        "|---" * 17 + "|",
    ]
    for (model, template, n, h, x, fps), r in zip(CARICATURE, rows, strict=True):
        match = "" if r["match_secs"] is None else f"{r['match_secs']:.2f}"
        lines.append(
            f"| {model}, {template} | {n} | {h} | {x} | {fps} | {short(r['shape'])}, {short(r['template'])} | {r['vertices']:,} "
            f"| {r['harmonics_secs']:.2f} | {match} | {r['difference_secs']:.3f} | {r['picking_ms']:.2f} | {r['painting_ms']:.2f} "
            f"| {r['filters_ms']:.2f} ({r['smoothing_ms']:.2f}) | {r['synthesis_ms']:.2f} | {r['normals_ms']:.2f} "
            f"| {r['drawing_ms']:.1f} | {r['fps']:.1f} |"
        )
    return lines


def music(rows):
    lines = [
        "| paper | n | K | once, s | fps | ours | n | K | once, s | S | mapping | synthesis | normals | drawing | fps |",
        "|---" * 15 + "|",
    ]
    for i, r in enumerate(rows):
        model, n, k, secs, fps = MUSIC[i // 3]
        lines.append(
            f"| {model} | {n:,} | {k} | {secs} | {fps[i % 3]} | {short(r['mesh'])} | {r['vertices']:,} | {r['harmonics']} "
            f"| {r['preprocess_secs']:.2f} | {r['items']} | {r['mapping_ms']:.2f} | {r['synthesis_ms']:.2f} "
            f"| {r['normals_ms']:.2f} | {r['drawing_ms']:.1f} | {r['fps']:.1f} |"
        )
    return lines


def main():
    measured = json.loads(pathlib.Path(sys.argv[1]).read_text())
    text = [
        "## Table 1 of both papers",
        "",
        f"{machine()}, {measured['threads']} threads, drawn by {measured['device']}. Made by `bench/tables/run`.",
        "",
        "Real meshes with the first harmonics of their plain cotangent Laplacian (paper mode), solved anew. No mesh of the papers "
        "is at hand: each row stands beside the nearest that is, so that n differs. Milliseconds are medians. The papers' machines "
        "are a 2.8 GHz processor with a GeForce GT 9600M (2010) and a 3.06 GHz one with a GeForce GT 130 (2012).",
        "",
        "The caricature paper's: K = 512, a stroke of the brush in each frame. *Picking* finds the point of the deformed shape "
        "under the pointer, *painting* dabs there, *filters* are χ by the sharp cut at 96 and the coefficients of all three models "
        "(in brackets χ alone, computed from nothing), then the three models are deformed, lit and drawn side by side at 1024×768. "
        "In the paper picking and smoothing χ take 39 ms on average.",
        "",
        *caricature(measured["caricature"]),
        "",
        "The music paper's: harmonics and symmetry once; then spectrum and mapping, deformation, normals and drawing of S items at "
        "1024×768 for a frame of the sample tune. The paper's frames with one item are deformed by its CPU.",
        "",
        *music(measured["music"]),
    ]
    write_section("tables", "\n".join(text))


if __name__ == "__main__":
    main()
