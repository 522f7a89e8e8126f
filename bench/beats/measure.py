#!/usr/bin/env python3
"""Beats of known songs: ours (whole song known, and while listening), librosa and aubio, in one run.

usage: bench/beats/measure.py [--data FOLDER] [--forms] [--write]
The songs are those of the data folder (default ../shared/data/audio or $CHLADNI_DATA/audio) that have
known beats, 24 that `beat_songs` composes (and 14 whose bars and sections are known, too), and 31 that other people wrote as MIDI (see midi_songs.py; left
out where Debian's openttd-openmsx, fluidsynth and timgm6mb-soundfont are not installed). Every other one of these
31 was held out when the tracker's constants were chosen. PEERS_PYTHON names a Python with librosa; aubio
is looked for in /usr/bin/python3. --forms measures bars and sections alone; --write puts the tables into BENCHMARKS.md.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import midi_songs

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import processor, write_section

ROOT = pathlib.Path(__file__).resolve().parents[2]
WINDOW_SECS = 0.07
KNOWN = [
    ("impulses_1second_44100_st.wav", "impulses.beats.txt"),
    ("techno_loop.mp3", "techno_loop.beats.txt"),
    ("Chord_Detection_Test.flac", "Chord_Detection_Test.beats.txt"),
    ("sample.wav", "sample.beats"),
]


def truth_of(path):
    lines = pathlib.Path(path).read_text().splitlines()
    return [float(line.split()[0]) for line in lines if line.strip() and not line.startswith("#")]


def f_measure(found, truth, window_secs=WINDOW_SECS):
    """Beats paired one to one within ±70 ms, or another window."""
    i = j = hits = 0
    while i < len(found) and j < len(truth):
        off = found[i] - truth[j]
        if abs(off) <= window_secs:
            hits, i, j = hits + 1, i + 1, j + 1
        elif off < 0:
            i += 1
        else:
            j += 1
    return 2 * hits / max(len(found) + len(truth), 1)


def octave(tempo, true_tempo):
    """Whether a tempo is right within 2 %, or right but for an octave, or wrong."""
    for factor, word in [(1, "right"), (2, "double"), (0.5, "half")]:
        if true_tempo and abs(tempo / (factor * true_tempo) - 1) < 0.02:
            return word
    return "wrong"


def lines_of(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"skipped {command[0]} {command[1]}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
        return None
    return [json.loads(line) for line in done.stdout.splitlines()]


def main():
    arguments = sys.argv[1:]
    data = pathlib.Path(os.environ.get("CHLADNI_DATA", ROOT.parent / "shared" / "data")) / "audio"
    if "--data" in arguments:
        data = pathlib.Path(arguments[arguments.index("--data") + 1])
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "chladni-sound", "--examples"], cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([target / "beat_songs", folder], check=True)
        python = os.environ.get("PEERS_PYTHON", "python3")
        here = pathlib.Path(__file__).parent
        forms = form_table(sorted(pathlib.Path(folder).glob("form-*.wav")), target, python, here)
        print(forms)
        if "--write" in arguments:
            write_section("forms", f"## Bars and sections\n\n{forms}")
        if "--forms" in arguments:
            return
        beside = lambda wav: (wav, wav.with_name(wav.name.removesuffix(".wav") + ".beats.txt"))
        composed = [beside(wav) for wav in sorted(pathlib.Path(folder).glob("*.wav")) if not wav.name.startswith("form-")]
        written = [beside(midi_songs.render(midi, pathlib.Path(folder))) for midi in midi_songs.installed()]
        groups = {
            "recordings": [(data / song, data / truth) for song, truth in KNOWN if (data / song).exists()],
            "composed by us": composed,
            "MIDI, used to choose constants": written[0::2],
            "MIDI, held out": written[1::2],
        }
        songs = [song for group in groups.values() for song in group]
        paths = [str(song) for song, _ in songs]
        truths = [truth_of(truth) for _, truth in songs]
        ours = lines_of([str(target / "beat_lists"), *paths])
        columns = {
            "Chladni, whole song": ours and [line["whole"] for line in ours],
            "librosa, whole song": lines_of([python, str(here / "peer_librosa.py"), *paths]),
            "Chladni, listening": ours and [line["causal"] for line in ours],
            "aubio, listening": lines_of(["/usr/bin/python3", str(here / "peer_aubio.py"), *paths]),
        }
    columns = {name: column for name, column in columns.items() if column}
    table = render(groups, truths, columns)
    print(table)
    if "--write" in arguments:
        write_section("beats", f"## Beats\n\n{table}")


def form_table(songs, target, python, here):
    """Bars and sections of the songs with a form; each second one was held out."""
    truth = lambda song, what: truth_of(song.with_suffix(f".{what}.txt"))
    ours = lines_of([str(target / "beat_lists"), *map(str, songs)])
    counted = [word for song in songs for word in (str(len(truth(song, "sections"))), str(song))]
    peer = lines_of([python, str(here / "peer_librosa_sections.py"), *counted])
    names = ["bars, whole song", "bars, listening", "sections, whole song", "sections, listening"]
    names += ["sections, librosa (told how many)"] if peer else []
    rows = ["| song | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    scores = []
    for k, song in enumerate(songs):
        bars, sections = truth(song, "bars"), truth(song, "sections")
        bar_secs = 1.01 * (bars[1] - bars[0])
        score = [f_measure(ours[k][by]["bars_secs"], bars) for by in ("whole", "causal")]
        score += [f_measure(ours[k]["whole"]["sections_secs"], sections, bar_secs),
                  f_measure(ours[k]["causal"]["sections_secs"], sections, 5 * bar_secs)]
        score += [f_measure(peer[k]["sections_secs"], sections, bar_secs)] if peer else []
        scores.append(score)
        rows.append(f"| {song.stem[8:]} | " + " | ".join(f"{s:.3f}" for s in score) + " |")
    for name, part in (("used to choose constants", scores[0::2]), ("held out", scores[1::2])):
        means = " | ".join(f"**{sum(column) / len(part):.3f}**" for column in zip(*part))
        rows.append(f"| **mean of {len(part)} {name}** | {means} |")
    head = (f"F-measure for songs that `beat_songs` composes with a known form, on {processor()}; made by `bench/beats/measure.py --forms "
            "--write`. Bars within ±70 ms; sections within a bar, and within five while listening, where they are noticed late by design. "
            "Each second song was held out when the constants were chosen.\n\n")
    return head + "\n".join(rows) + "\n"


def render(groups, truths, columns):
    songs = [song for group in groups.values() for song in group]
    rows = ["| song | true bpm | " + " | ".join(columns) + " |", "|---|---|" + "---|" * len(columns)]
    scores = {name: [] for name in columns}
    right = {name: 0 for name in columns}
    octaves = {name: 0 for name in columns}
    for k, ((song, _), truth) in enumerate(zip(songs, truths)):
        true_tempo = 60 * (len(truth) - 1) / (truth[-1] - truth[0])
        cells = []
        for name, column in columns.items():
            score = f_measure(column[k]["beats_secs"], truth)
            verdict = octave(column[k]["tempo_bpm"], true_tempo)
            scores[name].append(score)
            right[name] += verdict == "right"
            octaves[name] += verdict in ("half", "double")
            cells.append(f"{score:.3f} ({column[k]['tempo_bpm']:.1f}{'' if verdict == 'right' else ', ' + verdict})")
        rows.append(f"| {song.stem} | {true_tempo:.1f} | " + " | ".join(cells) + " |")
    mean = lambda values: sum(values) / max(len(values), 1)
    means = lambda part: " | ".join(f"**{mean(part(scores[name])):.3f}**" for name in columns)
    first = 0
    for name, group in groups.items():
        last = first + len(group)
        if group:
            rows.append(f"| **mean of {len(group)} {name}** | | " + means(lambda s: s[first:last]) + " |")
        first = last
    rows.append("| **mean of all** | | " + means(lambda s: s) + " |")
    rows.append("| tempo within 2 %; an octave off | | "
                + " | ".join(f"{right[n]} of {len(songs)}; {octaves[n]}" for n in columns) + " |")
    took = " | ".join(f"{sum(line['took_secs'] for line in column):.1f} s" for column in columns.values())
    rows.append(f"| time for all, one thread, decoding excluded | | {took} |")
    head = (f"F-measure (±70 ms) and tempo found, all in one run on {processor()}; "
            "made by `bench/beats/measure.py --write`. The songs composed by us (24 s each), the recordings and half of the "
            "MIDI songs (40 s of each song of Debian's openttd-openmsx, played by fluidsynth; truth is the quarter note) "
            "were also used to choose the tracker's constants; the other half was not.\n\n")
    return head + "\n".join(rows) + "\n"


if __name__ == "__main__":
    main()
