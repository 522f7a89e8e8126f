"""Runs the program on large scans and writes BENCHMARKS.md. usage: measure.py TARGET/release IGEA"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

release, igea = pathlib.Path(sys.argv[1]), sys.argv[2]
CHLADNI, BENCH = str(release / "chladni"), str(release / "chladni-bench")


def run(folder, *command):
    """What it printed, seconds, and gigabytes at most; with an empty cache."""
    env = {**os.environ, "CHLADNI_CACHE": tempfile.mkdtemp(dir=folder)}
    began = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env, cwd=folder)
    printed = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed")
    return printed, time.monotonic() - began, usage.ru_maxrss / 1e6


def positions(path):
    """The vertices of a PLY that the program wrote."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + 11
    lines = data[:end].decode().splitlines()
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[-1])
    return np.frombuffer(data, "<f8", 3 * count, end).reshape(-1, 3)


rows, differences = [], []
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    for times in (1, 2):
        scan = folder / f"scan{times}.ply"
        vertices = run(folder, BENCH, "--quiet", "scan", os.path.abspath(igea), "--times", str(times), "-o", str(scan))[0].split()[0]
        for template, mu in (("self:lowpass=20", "-1"), ("sample:template", "-0.8")):
            moved = {}
            # All vertices of the larger one at once take 16 GB.
            for proxy in ([], ["--proxy", "0"]) if times == 1 else ([],):
                out = folder / "out.ply"
                line = [CHLADNI, "--quiet", "caricature", str(scan), template, "--mu", mu, "-k", "512", "-o", str(out), *proxy]
                _, secs, gigabytes = run(folder, *line)
                moved["all" if proxy else "proxy"] = positions(out)
                way = "all vertices" if proxy else "proxy"
                rows.append(f"| {int(vertices):,} | `{template}` | {way} | {secs:.1f} | {gigabytes:.1f} |")
            if "all" in moved:
                rest = positions(scan)
                far = np.linalg.norm(moved["all"] - rest, axis=1)
                off = np.linalg.norm(moved["all"] - moved["proxy"], axis=1)
                differences.append(f"{100 * off.mean() / far.mean():.1f} % of the mean movement for `{template}`")
    strokes = json.loads(run(folder, BENCH, "--quiet", "caricature", str(scan), "--json")[0])
table = "\n".join(rows)
acts = "\n".join(f"| {row['what']} | {row['median_ms']:.1f} |" for row in strokes)
write_section(
    "scan",
    f"""## Large scans

{machine()} at the end. igea.ply with its triangles divided in four once and twice and bumps raised on it, from the file to
the written result of one layer, K = 512, nothing cached. Made by `bench/scan/run`.

| vertices | template | on | s | GB at most |
|---|---|---|---|---|
{table}

The proxy's result lies from that of all vertices by {' and '.join(differences)}, on average.

What a hand does on the larger one, through its proxy of {strokes[0]['vertices']:,} vertices:

| what | ms |
|---|---|
{acts}""",
)
