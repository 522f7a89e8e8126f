"""Writes what bench/card/run measured into BENCHMARKS.md. Usage: measure.py FOLDER"""

import json
import pathlib
import sys

import numpy
from PIL import Image

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
import twins  # noqa: E402
from film_report import filming_secs  # noqa: E402
from section import processor, write_section  # noqa: E402

folder = pathlib.Path(sys.argv[1])

# The share of the card's copy bandwidth at which synthesis is to read the basis.
AIM = 0.6


def apart():
    """How far the pictures of card and processor are apart, by the measures of the conformance suite of chladni-view: the
    worst mean, in levels, and the worst share of pixels that are more than 20 levels off all around the same place."""
    worst = [0.0, 0.0]
    for mine in sorted((folder / "pictures").glob("*-processor.png")):
        theirs = mine.with_name(mine.name.replace("-processor.png", "-device.png"))
        a, b = (numpy.asarray(Image.open(path).convert("RGB")).astype(int) for path in (mine, theirs))
        wide = numpy.pad(b, ((1, 1), (1, 1), (0, 0)), "edge")
        around = [wide[y : y + len(b), x : x + b.shape[1]] for y, x in numpy.ndindex(3, 3)]
        low, high = numpy.min(around, 0) - 20, numpy.max(around, 0) + 20
        off = ((a < low) | (a > high)).any(2).mean()
        worst = [max(worst[0], abs(a - b).mean()), max(worst[1], off)]
    return worst


mean, off = apart()
devices, _, table = twins.read((folder / "twins").read_text())
rows = json.loads((folder / "synth.json").read_text())

lines = [
    "## With a graphics card",
    "",
    f"{processor()}; devices: {'; '.join(devices)}. Made by `bench/card/run`.",
    "",
    "Pictures, four samples a pixel on both, milliseconds of a frame: the median of 21, the best, the processor time of all "
    "threads together, and times the first column's median (scenes as in *The processor beside the graphics device*):",
    "",
    *table,
    "",
    f"Their pictures are at most {mean:.2f} of 255 levels apart on average, and at most {1e6 * off:.0f} of a million pixels differ by more than 20 "
    "levels from all that lies around the same place.",
    "",
    "Synthesis and drawing as in *Synthesis and drawing* (shapes of the papers' sizes): milliseconds, frames a second of all "
    "three, the published rate, how many times as fast as on the processor synthesis and normals are, what the card's "
    "synthesis moves (the basis once, and positions), and what share that is of a copy of the basis on the card, which reads and writes:",
    "",
    "| model | n | K | S | processor: synthesis, normals, ms | card: synthesis, normals, drawing, ms | drawn, frames a second | published | times as fast "
    "| moved, GB/s | a copy, GB/s | share |",
    "|" + "---|" * 12,
]
shares = []
of = {(r["model"], r["items"], r["backend"]): r for r in rows}
for (model, items, backend), card in of.items():
    cpu = of.get((model, items, "cpu"))
    if backend != "gpu" or cpu is None:
        continue
    draw = f"{card['draw_ms']:.2f}" if card["draw_ms"] is not None else ""
    drawn = f"{card['drawn_fps']:.0f}" if card["drawn_fps"] is not None else ""
    published = f"{card['published_fps']:.1f}" if card["published_fps"] is not None else ""
    ratio = (cpu["synthesis_ms"] + cpu["normals_ms"]) / (card["synthesis_ms"] + card["normals_ms"])
    moved = card["bytes_moved"] / card["synthesis_ms"] / 1e6
    shares.append(card["bandwidth_share"])
    lines.append(
        f"| {model} | {card['vertices']:,} | {card['harmonics']:,} | {items} | {cpu['synthesis_ms']:.2f}, {cpu['normals_ms']:.2f} "
        f"| {card['synthesis_ms']:.2f}, {card['normals_ms']:.2f}, {draw} | {drawn} | {published} | {ratio:.1f} "
        f"| {moved:.0f} | {moved / shares[-1]:.0f} | {100 * shares[-1]:.0f} % |"
    )
if shares:
    reached = sum(share >= AIM for share in shares)
    lines += ["", f"Aim: {100 * AIM:.0f} % of a copy. {reached} of {len(shares)} rows reach it; the best has {100 * max(shares):.0f} %."]
lines += [
    "",
    "Films of 8 s of our tune at 30 frames a second (`chladni dance sample:octopus sample:tune`, K = 512, the look aurora), the encoder left out: "
    "times real time once the beats are found and the harmonics are there, and milliseconds a frame:",
    "",
    "| film | size | who draws and deforms | times real time | drawing | synthesis and normals | flash guard |",
    "|" + "---|" * 7,
]
for name, film, size in (("one-720", "one octopus", "1280×720"), ("gallery-720", "gallery of twelve", "1280×720"), ("gallery-2160", "gallery of twelve", "3840×2160")):
    for draw in ("cpu", "gpu"):
        r = json.loads((folder / f"film-{name}-{draw}.json").read_text())
        ms = {k: 1e3 * v / r["frames"] for k, v in r["seconds"].items()}
        lines.append(
            f"| {film} | {size} | {r['device']}; {r['synthesis']} | {r['film_secs'] / filming_secs(r):.2f} | {ms['drawing']:.1f} "
            f"| {ms['synthesis'] + ms['normals']:.1f} | {ms['guarding']:.1f} |"
        )
write_section("card", "\n".join(lines))
print("\n".join(lines))
