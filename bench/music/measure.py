"""Measures the music instrument and writes its section of BENCHMARKS.md. Called by bench/music/run."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import scipy.spatial
import trimesh

from seen import seen
from sync import sync

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import machine, write_section

chladni, bench = sys.argv[1:]
K = 100
GALLERY_MESHES = ["animals/spot.obj", "heads/face.obj", "shapes/armadillo.obj"]
SONGS = ["dubstep.wav", "techno_loop.mp3", "music.ogg", "sample.wav", "Chord_Detection_Test.flac", "lmms24bit.wav"]


def run(*arguments, program=chladni):
    return subprocess.run([program, "--quiet", *map(str, arguments)], check=True, capture_output=True).stdout


def mirror_blob(path):
    """Its own mirror image in x and in no other plane, with single eigenvalues."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    x, y, z = mesh.vertices.T
    arms = 0.9 * x * x * (0.4 + 0.6 * y)
    mesh.vertices = np.stack(
        [1.3 * x + 0.5 * x * arms, 0.8 * y + arms + 0.1 * z * z, 0.6 * z + 0.35 * y * y - 0.15 * x * x], 1
    )
    mesh.export(path)


def symmetry(path, folder):
    """Our classes against the sign of <H, H o T>, T the mirror in x taken to the nearest vertex."""
    classes = np.array(json.loads(run("symmetry", path, "-k", K + 1, "--json"))["classes"])
    run("basis", path, "-k", K + 1, "-o", folder / "basis.npz")
    basis = np.load(folder / "basis.npz")
    vectors, mass, values = basis["eigenvectors"], basis["mass"], basis["eigenvalues"]
    points = np.zeros((len(mass), 3))
    row = basis["operator_vertex"]
    given = np.array([line.split()[1:4] for line in open(path) if line.startswith("v ")], float)
    points[row[row >= 0]] = given[row >= 0]
    middle = 0.5 * (points[:, 0].min() + points[:, 0].max())
    image = points * [-1, 1, 1] + [2 * middle, 0, 0]
    _, nearest = scipy.spatial.cKDTree(points).query(image)
    truth = np.sign(np.einsum("v,vk,vk->k", mass, vectors, vectors[nearest]))
    gaps = np.diff(values)
    single = [k for k in range(1, K) if gaps[k - 1] > 1e-3 * values[k] and gaps[k] > 1e-3 * values[k]]
    return sum(classes[k] == truth[k] for k in single), len(single), len(mass)


def main():
    data = pathlib.Path(os.environ.get("CHLADNI_DATA", "../shared/data")) / "meshes"
    lines = ["## Music", ""]
    meshes = [data / name for name in GALLERY_MESHES if (data / name).exists()]
    songs = [data.parent / "audio" / name for name in SONGS if (data.parent / "audio" / name).exists()]
    named = [part for kind, files in [("--shape", meshes), ("--song", songs)] for file in files for part in (kind, file)]
    measured = json.loads(run("music", "--json", *named, program=bench))
    lines += [
        f"{machine()}, {measured['timing'][0]['threads']} threads. Made by `bench/music/run`.",
        "",
        "Milliseconds a frame, medians, on the processor: a bumpy sphere with its harmonics, the sample tune. Targets: "
        "resonators at most 0.3 ms, spectrum and mapping together at most 1 ms, all of it at most 10 ms.",
        "",
        "| form | n | K | S | spectrum | resonators | mapping | synthesis | normals | together |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in measured["timing"]:
        parts = " | ".join(f"{r[key + '_ms']:.2f}" for key in ["spectrum", "resonators", "mapping", "synthesis", "normals", "total"])
        lines.append(f"| {r['form']} | {r['vertices']:,} | {r['harmonics']} | {r['items']} | {parts} |")
    lines += [
        "",
        "A frame at 30 a second of a gallery without sand and with it, up to what is drawn. *Sand*: its two steps, each with the "
        "spectrum, the oscillators and the mapping of its time. *Sound*: spectrum and oscillators of the frame. *Grains*: their places. "
        "Target: at most 8 ms on 4 cores.",
        "",
        "| shape | n | K | S | grains | sand | sound | mapping | synthesis | normals | grains | together |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in measured["frames"]:
        parts = " | ".join(f"{r[key + '_ms']:.2f}" for key in ["sand", "sound", "mapping", "synthesis", "normals", "grains", "total"])
        lines.append(f"| {r['shape']} | {r['vertices']:,} | {r['harmonics']} | {r['items']} | {r['grains']:,} | {parts} |")
    lines += [
        "",
        "Left and right: a tone in one channel or in both, the direct mapping, K = 128. *Ratio*: displacement energy of "
        "the tone's half over that of the other; of both, left over right (targets: 5 in halves, 2 in modal, and 1 to 2 % in mono). "
        "*Outwards*: mean displacement along the normals of the tone's half minus that of the other, over the root mean square "
        "(modal: above -0.05, as some harmonics hardly lean to either side). *Mirror error*: how far the shape is from its own mirror image, over the largest displacement "
        "(the filter form keeps it; mono keeps it in all forms).",
        "",
        "| shape | form | tone | channel | ratio | outwards | mirror error |",
        "|---|---|---|---|---|---|---|",
    ]
    for r in measured["stereo"]:
        ratio = f"{r['energy_ratio']:.{3 if r['channel'] == 'both' else 1}f}"
        lines.append(
            f"| {r['shape']} | {r['form']} | {r['tone_hz']:.0f} Hz | {r['channel']} | {ratio} | {r['direction']:+.2f} | "
            f"{r['mirror_error']:.0e} |"
        )
    t = measured["transfer"]
    lines += [
        "",
        f"{t['presets']} presets bred on the octopus and written as files move the head {t['ratio'][0]:.2f} to "
        f"{t['ratio'][2]:.2f} times as far as the octopus to the sample tune, median {t['ratio'][1]:.2f} (root mean square over the "
        "surface, mean over time, as a share of the box).",
        "",
        "Folds: the share of a shape's triangles that are turned over, in the worst of twelve items at gain 1 (K = 128): all "
        "bands at full scale in both channels, in one, or in the middle and the side; and each band alone (target: 0.5 %).",
        "",
        "| shape | triangles | form | initial: all bands | one | bred: all bands | one |",
        "|---|---|---|---|---|---|---|",
    ]
    folds = [r for r in measured["folds"] if r["gallery"] in ("initial", "bred")]
    for initial, bred in zip(folds[::2], folds[1::2]):
        shares = " | ".join(f"{100 * r[key]:.2f} %" for r in (initial, bred) for key in ("all_bands", "one_band"))
        lines.append(f"| {initial['shape']} | {initial['triangles']:,} | {initial['form']} | {shares} |")
    built_in = {}
    for r in measured["folds"]:
        if r["gallery"] not in ("initial", "bred"):
            built_in.setdefault(r["shape"], []).append((max(r["all_bands"], r["one_band"]), r["gallery"]))
    lines += ["", "The same of the built-in dances, each in its own form and timbre: " + "; ".join(
        f"{shape}: {len(rows)} dances, worst {100 * max(rows)[0]:.2f} % ({max(rows)[1]})" for shape, rows in built_in.items()) + "."]
    lines += [
        "",
        f"Movement of twelve items in the form to begin with, to sample:tune and at most 20 s of each of {', '.join(p.name for p in songs)}: "
        "root mean square over the surface, mean over time and songs, as a share of the box. *Least*: the least moved item over "
        "the median one (target: a third); *least change*: the same of what changes within a tenth of a second.",
        "",
        "| shape | gallery | items | least | least change |",
        "|---|---|---|---|---|",
    ]
    for r in measured["movement"]:
        items = " ".join(f"{100 * item:.2f}" for item in r["items"])
        lines.append(f"| {r['shape']} | {r['gallery']} | {items} % | {r['least']:.2f} | {r['least_change']:.2f} |")
    lines += [
        "",
        f"Symmetry: harmonics 1 to {K - 1} of single eigenvalue whose class is the sign of ⟨H, H∘T⟩, T the mirror taken to the "
        "nearest vertex by SciPy's k-d tree (target: 95 %).",
        "",
        "| shape | n | agree | of | share |",
        "|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        mirror_blob(folder / "blob.obj")
        shapes = [("generated", folder / "blob.obj")]
        named = ["shapes/scorpion_low_resolution.obj", "animals/spot.obj", "heads/face.obj"]
        shapes += [(n, data / n) for n in named if (data / n).exists()]
        for name, path in shapes:
            agree, of, n = symmetry(path, folder)
            lines.append(f"| {name} | {n:,} | {agree} | {of} | {100 * agree / of:.1f} % |")
        lines += [
            "",
            "Films of a swelling tone of 220 Hz (`bench/music/seen.py`), defaults: how many times as much the sounding half of the "
            "picture changes from frame to frame as the other (target: 3). Mono is judged on the movement, above: the lights are not "
            "the same from both sides.",
            "",
            "| shape | hard left | hard right |",
            "|---|---|---|",
        ]
        filmed = ["animals/spot.obj", "shapes/suzanne.obj", "shapes/armadillo.obj"]
        bodies = [(n, n) for n in ["sample:octopus", "sample:head"]]
        bodies += [(n, data / n) for n in filmed if (data / n).exists()]
        for name, body in bodies:
            left, right = seen(chladni, folder, body)
            lines.append(f"| {name} | {left:.1f} | {right:.1f} |")
        lines += [
            "",
            "A click track as a film (`bench/music/sync.py`): when the click sounds and when the picture moves most, both decoded from "
            "the MP4 by ffmpeg. *Late* is the picture after the click (negative: before), the worst of all clicks.",
            "",
            "| frames a second | a frame | clicks | worst late | within one frame |",
            "|---|---|---|---|---|",
        ]
        for fps in [24, 30, 60]:
            late = sync(chladni, folder, fps)
            worst = max(late, key=abs)
            within = "yes" if abs(worst) <= 1.0 / fps + 1e-3 else "NO"
            lines.append(f"| {fps} | {1e3 / fps:.1f} ms | {len(late)} | {1e3 * worst:.1f} ms | {within} |")
    print("\n".join(lines))
    if meshes or songs:
        write_section("music", "\n".join(lines))
    else:
        print(f"BENCHMARKS.md stays as it is: {data.parent} has no meshes and songs", file=sys.stderr)


main()
