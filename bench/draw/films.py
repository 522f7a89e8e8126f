"""Films and single pictures without a card: how long they take, and of whose time.

usage: bench/draw/films.py     (writes its section of BENCHMARKS.md)

CHLADNI   the program (default: target/release/chladni)
"""

import json
import os
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from film_report import filming_secs  # noqa: E402
from section import machine, write_section  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHLADNI = os.environ.get("CHLADNI", str(ROOT / "target/release/chladni"))
DANCE = "dance sample:octopus sample:tune --size 1280x720 --duration 8 --json".split()
FILMS = [("one octopus", [], 4), ("gallery of twelve", ["--gallery", "12"], 1)]
LOOKS = ["plain", "aurora"]
# Only once each: a driver of software takes ten times as long.
REPEATS = {"cpu": 3, "gpu": 1}
SHAPES = ["sample:human", ROOT.parent / "shared/data/meshes/shapes/armadillo.obj", ROOT.parent / "shared/data/meshes/heads/face.obj"]


# Stands in for ffmpeg on the PATH, and writes down how long it took of the processors' time.
CLOCKED = """#!/bin/bash
{ffmpeg} "$@"
code=$?
times > {times}
exit $code
"""


def clock_ffmpeg(folder):
    """From now on, ffmpeg is clocked; what it took of the processors' time is in the file that is returned."""
    times, clocked = folder / "times", folder / "ffmpeg"
    clocked.write_text(CLOCKED.format(ffmpeg=shutil.which("ffmpeg"), times=times))
    clocked.chmod(0o755)
    os.environ["PATH"] = f"{folder}{os.pathsep}{os.environ['PATH']}"
    return times


def encoder_secs(times):
    """The user's and the system's seconds of what was clocked last."""
    minutes = re.findall(r"(\d+)m([\d.]+)s", times.read_text().splitlines()[1])
    return sum(60 * int(m) + float(s) for m, s in minutes)


def run(*arguments):
    """What it prints, its seconds, and those of all processors, its ffmpeg's too."""

    def processor_secs():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before, start = processor_secs(), time.perf_counter()
    done = subprocess.run([CHLADNI, "--quiet", *map(str, arguments)], check=True, capture_output=True, text=True)
    return done.stdout, time.perf_counter() - start, processor_secs() - before


def film(options, look, draw, folder, times):
    """Medians of a film: times real time, the same without the start, milliseconds of all processors a frame, and of those
    ffmpeg's."""
    rows = []
    for _ in range(REPEATS[draw]):
        printed, _, processor = run(*DANCE, *options, "--look", look, "--draw", draw, "-o", folder / "film.mp4")
        report = json.loads(printed)
        ms = [1e3 * secs / report["frames"] for secs in (processor, encoder_secs(times))]
        rows.append([report["times_real_time"], report["film_secs"] / filming_secs(report), *ms])
    return report["device"], *map(statistics.median, zip(*rows))


def films(folder, times):
    """The table of films; drivers of software stand beside the processor."""
    lines = [
        "| film | look | drawn by | times real time | the start left out | aim | all processors, ms a frame | of them ffmpeg |",
        "|" + "---|" * 8,
    ]
    for name, options, aim in FILMS:
        for look in LOOKS:
            for draw in REPEATS:
                try:
                    device, whole, steady, processor, encoder = film(options, look, draw, folder, times)
                except subprocess.CalledProcessError as error:
                    print(error.stderr, file=sys.stderr)
                    continue
                lines.append(
                    f"| {name} | {look} | {device} | {whole:.2f} | {steady:.2f} | {aim} | {processor:.0f} | {encoder:.0f} |"
                )
                print(lines[-1], flush=True)
    return lines


def pictures(folder):
    """Milliseconds that a picture of 1600×900 adds to a caricature, harmonics in the cache, medians of seven."""
    lines = ["| shape | milliseconds of its picture |", "|---|---|"]
    for shape in SHAPES:
        if not str(shape).startswith("sample:") and not shape.exists():
            print(f"{shape} is not here")
            continue
        usual = ["caricature", shape, "ellipsoid", "--mu", "-1.2", "-o", folder / "out.glb"]
        run(*usual)
        times = [[run(*usual, *more)[1] for more in ([], ["--render", folder / "out.png"])] for _ in range(7)]
        alone, drawn = (statistics.median(column) for column in zip(*times))
        name = shape if isinstance(shape, str) else shape.name
        lines.append(f"| `{name}` | {1e3 * (drawn - alone):.0f} |")
    return lines


def main():
    said = machine()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        times = clock_ffmpeg(folder)
        # Fills the cache of harmonics.
        run(*DANCE[:3], "--duration", "1", "--size", "320x180", "-o", folder / "first.mp4")
        rows, drawn = films(folder, times), pictures(folder)
    text = f"""## Films and single pictures without a card

{said}. `{' '.join(['chladni', *DANCE])}`, K = 512, 30 frames a second, medians of {REPEATS['cpu']} on the processor, once by a
driver of software. *The start left out*: without reading, stance and mirror plane of the shape, and finding the song's beats, which
is done once. The processors' time is that of the whole command by frames, start included; ffmpeg's is its own,
with the change of colors. Made by `bench/draw/films.py`.

{chr(10).join(rows)}

Four times real time at 30 frames a second leaves two cores 17 ms of their time a frame, and once leaves 67. One octopus is drawn, deformed,
looked through for flashes and encoded for more than that, whoever waits for whom; no preset of x264 makes up for it.

Pictures of 1600×900, `chladni caricature SHAPE ellipsoid --mu -1.2 -o out.glb --render out.png` beside the same without `--render`,
harmonics in the cache, medians of seven (aim: 150 ms). Where a file does not say how it stands, that is estimated, too:

{chr(10).join(drawn)}"""
    write_section("films", text)
    print(text)


if __name__ == "__main__":
    main()
