"""Can one tell from the silent picture which song plays?

Each shape is filmed to each song. The movement of the picture is compared with the onsets of every song, and its distance from
the mean picture with the loudness; the song that agrees best is the one that the picture tells. Chance tells one song of each row.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "beats"))
import midi_songs  # noqa: E402
from section import processor, write_section  # noqa: E402

WIDTH, HEIGHT, FPS, SECS = 192, 144, 25, 5
RATE_HZ = 22_050
BODIES = ["octopus", "head", "bell", "human", "cat", "plate"]
# Songs by others (Debian's openttd-openmsx), of those that no constant was chosen on.
FRESH = 5
# The picture may come a frame early or four late.
LAGS = range(-1, 5)

HEAD = """## What the silent picture says

`bench/seen/run` on {machine}: films of {secs} s, {width}×{height}, {fps} frames a second, with the defaults of `chladni dance`. *told*:
songs whose own film agrees best with them (chance is 1). *own* and *others*: mean correlation of a film with its song and with the other
songs. *change*: mean difference of successive frames, of 255, and that of the calmest film. *cover*: share of the picture that is not
as its corner is, with glow, floor and shadow. *figure*: share in which the figure itself stands (what is opaque in the same films on a
transparent background, 5 frames a second). Aims: all but one told, own ≥ 0.5, others ≤ 0.2, change ≥ 3 and never below 1.5, cover
35–60 %. *Fresh songs*: {fresh}, to which nothing was ever adjusted.

Not background is also what a look lights: the halo of `gold` behind the bell reaches the rim of the picture at loud places, and a floor or
a shadow on it counts, as it does for the plate. The last column says how much of the picture the figure itself fills: one that is slim or
flat fills less than a third of it in most shots (docs/music.md says what a shot may cut off). The plate opens with sand, which draws the tone
that sounds and takes seconds for it, so its pictures do not follow the beat.

| songs | shape | told | own | others | change | least | cover | figure |
|---|---|---|---|---|---|---|---|---|
"""


def decode(path, *options):
    command = ["ffmpeg", "-loglevel", "error", "-i", str(path), "-t", str(SECS), *options, "-"]
    return subprocess.run(command, check=True, capture_output=True).stdout


def dance(chladni, body, song, fps, *options):
    command = [chladni, "--quiet", "dance", body, song, "--duration", str(SECS), "--size", f"{WIDTH}x{HEIGHT}"]
    subprocess.run([*command, "--fps", str(fps), *options], check=True, capture_output=True)


def filmed(chladni, body, song, folder):
    film = folder / "film.mp4"
    dance(chladni, body, song, FPS, "-o", str(film))
    frames = np.frombuffer(decode(film, "-an", "-f", "rawvideo", "-pix_fmt", "rgb24"), np.uint8)
    return frames.reshape(-1, HEIGHT, WIDTH, 3).astype(float)


def figure_share(chladni, body, song, folder):
    frames = pathlib.Path(tempfile.mkdtemp(dir=folder))
    dance(chladni, body, song, 5, "--frames", str(frames), "--background", "transparent")
    return np.mean([(np.asarray(Image.open(png).convert("RGBA"))[:, :, 3] > 127).mean() for png in frames.glob("*.png")])


def heard(song, frames):
    """Loudness and onset strength at each frame, from magnitudes of windows of two frames, compressed as the ear does."""
    sound = np.frombuffer(decode(song, "-ac", "1", "-ar", str(RATE_HZ), "-f", "f32le"), np.float32)
    hop = RATE_HZ // FPS
    sound = np.pad(sound, (hop, 2 * hop + frames * hop))
    windows = np.stack([sound[i * hop : (i + 2) * hop] for i in range(frames)]) * np.hanning(2 * hop)
    bands = np.log1p(10 * np.abs(np.fft.rfft(windows))[:, :200])
    rises = np.maximum(np.diff(bands, axis=0, prepend=bands[:1]), 0)
    return bands.sum(1), rises.sum(1)


def correlation(a, b):
    smooth = [np.convolve(x, np.ones(3) / 3, "same")[6:-2] for x in (a, b)]
    a, b = [(x - x.mean()) / (x.std() + 1e-9) for x in smooth]
    return float(np.mean(a * b))


def agreement(frames, song):
    """The better of movement with onsets and of distance from the mean picture with loudness, at the best lag."""
    movement = np.abs(np.diff(frames, axis=0, prepend=frames[:1])).mean((1, 2, 3))
    pose = np.abs(frames - frames.mean(0)).mean((1, 2, 3))
    loudness, onsets = song
    pairs = [(onsets, movement), (loudness, pose)]
    return max(correlation(np.roll(sound, lag), seen) for sound, seen in pairs for lag in LAGS)


def row(chladni, body, kind, songs, folder):
    films = [filmed(chladni, body, song, folder) for song in songs]
    # A film ends with its song.
    table = np.array([[agreement(film, heard(song, len(film))) for song in songs] for film in films])
    told = int((table.argmax(1) == np.arange(len(songs))).sum())
    own = np.diag(table).mean()
    others = (table.sum() - np.trace(table)) / max(len(songs) * (len(songs) - 1), 1)
    change = [np.abs(np.diff(film, axis=0)).mean() for film in films]
    # The corner shows background.
    ground = [np.median(film[:, :8, :8].reshape(-1, 3), 0) for film in films]
    cover = np.mean([(np.abs(film - g).sum(-1) > 40).mean() for film, g in zip(films, ground)])
    figure = np.mean([figure_share(chladni, body, song, folder) for song in songs])
    name = pathlib.Path(body).stem.removeprefix("sample:")
    return (
        f"| {kind} | {name} | {told} of {len(songs)} | {own:.2f} | {others:.2f} | {np.mean(change):.1f} | {min(change):.1f} | {cover:.0%} | {figure:.0%} |"
    )


def main():
    chladni = sys.argv[1]
    data = pathlib.Path(os.environ.get("CHLADNI_DATA", "../shared/data"))
    names = ["music.ogg", "techno_loop.mp3", "dubstep.ogg", "Chord_Detection_Test.flac", "sample.wav"]
    songs = [str(data / "audio" / name) for name in names if (data / "audio" / name).exists()]
    if len(songs) < 2:
        sys.exit(f"skipped: {data}/audio has no songs to tell apart; CHLADNI_DATA names another folder")
    animals = sorted((data / "meshes" / "animals").glob("spot.obj"))
    bodies = [f"sample:{name}" for name in BODIES] + list(map(str, animals))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        fresh = [midi_songs.render(midi, folder) for midi in midi_songs.installed()[1::2][:FRESH]]
        kinds = [("ours", songs)] + [("fresh", list(map(str, fresh)))] * (len(fresh) > 1)
        rows = [row(chladni, body, kind, songs, folder) for kind, songs in kinds for body in bodies]
    named = ", ".join(song.stem for song in fresh) or "none could be rendered here"
    head = HEAD.format(machine=processor(), secs=SECS, width=WIDTH, height=HEIGHT, fps=FPS, fresh=named)
    write_section("seen", head + "\n".join(rows))
    print("\n".join(rows))


if __name__ == "__main__":
    main()
