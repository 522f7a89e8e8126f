"""Measures what a person waits for and writes its section of BENCHMARKS.md. Called by bench/studio/run."""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

chladni, drawing_cost, bench = sys.argv[1:]
koala = pathlib.Path(os.environ["CHLADNI_DATA"]) / "meshes/animals/koala.obj"


def output(*command):
    return subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True).stdout


def start(folder):
    """Seconds from the command to the first picture, of runs with the harmonics in the cache."""
    shape = koala
    if not koala.exists():
        shape = pathlib.Path(folder) / "head.obj"
        output(chladni, "--quiet", "caricature", "sample:head", "ellipsoid", "--mu", 0, "-o", shape)
    text, seconds = output("bench/start/measure.sh", shape, 7), []
    while text.strip():
        run, end = json.JSONDecoder().raw_decode(text.strip())
        text = text.strip()[end:]
        seconds.append(run["first_picture_secs"])
    return [f"`bench/start/measure.sh {shape.name}`, {len(seconds)} starts with the harmonics in the cache: the first picture of the "
            f"shape stands in the window {statistics.median(seconds):.2f} s after the command (worst {max(seconds):.2f} s; target 1 s)."]


def controls():
    """What each control of the caricature room takes between the action and the drawing."""
    shape = koala if koala.exists() else "sample:head"
    rows = json.loads(output(bench, "--quiet", "caricature", shape, "--harmonics", 512, "--repeats", 25, "--json"))
    about = rows[0]
    lines = [
        f"`chladni-bench caricature {getattr(shape, 'name', shape)} --harmonics 512 --repeats 25`: n = {about['vertices']:,}, "
        f"K = {about['harmonics']}, {about['threads']} threads, milliseconds. Rows of *window* hold everything from the action to "
        "the figures handed to the device; only drawing is left out. Targets: the next frame, a stroke 16, a new shape 30.",
        "", "| what | median | fastest |", "|---|---|---|",
    ]
    return lines + [f"| {row['what']} | {row['median_ms']:.2f} | {row['fastest_ms']:.2f} |" for row in rows]


def drawing():
    return ["`cargo run --release -p chladni-view --example drawing_cost`, 1280×720: *cpu* is the processor's time on all cores.",
            "", "```", output(drawing_cost).rstrip(), "```"]


def film(folder):
    """How a film of 8 s is made, with its sound."""
    path = pathlib.Path(folder) / "film.mp4"
    arguments = ["dance", "sample:octopus", "sample:tune", "--size", "1280x720", "--duration", "8"]
    report = json.loads(output(chladni, "--quiet", *arguments, "--json", "-o", path))
    parts = ", ".join(f"{what} {value:.2f}" for what, value in report["seconds"].items())
    return [f"`chladni {' '.join(arguments)} --json`: {report['frames']} frames in {report['seconds']['total']:.1f} s, "
            f"{report['times_real_time']:.2f} times real time. Seconds: {parts}. Drawn on {report['device']} with "
            f"{report['samples']} samples a pixel; drawing, fetching and encoding overlap."]


def main():
    with tempfile.TemporaryDirectory() as folder:
        about = machine()
        parts = [["## The window, drawing and film", "", f"{about} at the start. Made by `bench/studio/run`."],
                 ["### Start", "", *start(folder)], ["### The caricature room", "", *controls()],
                 ["### Drawing", "", *drawing()], ["### Film", "", *film(folder)]]
    write_section("studio", "\n\n".join("\n".join(part) for part in parts))


main()
