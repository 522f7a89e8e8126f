"""A click track as an MP4: how long after each click the picture moves most.

Usage: sync.py CHLADNI [FPS …]
"""

import pathlib
import subprocess
import sys
import tempfile
import wave

import numpy as np

RATE, SECS, SIZE = 44_100, 5, (160, 120)
CLICKS = [0.731, 1.5, 2.267, 3.102, 4.05]


def click_track(path):
    sound = np.zeros(RATE * SECS)
    burst = 0.9 * np.exp(-np.arange(400) / 80) * np.sign(np.sin(np.arange(400) * 0.35))
    for at in CLICKS:
        start = round(at * RATE)
        sound[start : start + len(burst)] = burst
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(np.repeat((sound * 32767).astype("<i2"), 2).tobytes())


def session(path):
    """The item that answers the deepest harmonics, with nothing else that moves the picture."""
    actions = [
        'do = "switch"\nswitch = "beat-turns"\non = false',
        'do = "switch"\nswitch = "beat-lights"\non = false',
        'do = "set"\nparameter = "gain"\nvalue = 3.0',
        'do = "perform"\nitem = 1',
    ]
    text = "".join(f"[[actions]]\nat_secs = 0.0\nat_beat = 0.0\n{action}\n" for action in actions)
    path.write_text("format_version = 1\nseed = 2012\nsize = 12\n" + text)


def decode(film, *arguments):
    command = ["ffmpeg", "-v", "error", "-i", str(film), *arguments, "-"]
    return subprocess.run(command, check=True, capture_output=True).stdout


def sync(chladni, folder, fps):
    """Seconds from each click of the decoded sound to the middle of the decoded frame that moved most."""
    song, film = folder / "clicks.wav", folder / f"clicks-{fps}.mp4"
    click_track(song)
    session(folder / "session.toml")
    size = f"{SIZE[0]}x{SIZE[1]}"
    options = ["--size", size, "--fps", str(fps), "-k", "32", "--session", str(folder / "session.toml")]
    subprocess.run([chladni, "--quiet", "dance", "sample:octopus", str(song), *options, "-o", str(film)], check=True, stderr=subprocess.DEVNULL)
    sound = np.frombuffer(decode(film, "-vn", "-f", "f32le", "-ac", "1", "-ar", str(RATE)), "<f4")
    pixels = SIZE[0] * SIZE[1]
    frames = np.frombuffer(decode(film, "-an", "-f", "rawvideo", "-pix_fmt", "gray"), np.uint8)
    frames = frames.reshape(-1, pixels).astype(float)
    moved = np.abs(frames - frames[0]).mean(1)
    late = []
    for at in CLICKS:
        near = slice(round((at - 0.3) * RATE), round((at + 0.3) * RATE))
        # The encoder's filters ring before a click: its onset is where half its height is reached.
        loud = np.abs(sound[near])
        heard = near.start / RATE + np.argmax(loud > 0.5 * loud.max()) / RATE
        first, last = round((at - 0.3) * fps), round((at + 0.3) * fps)
        peak = first + int(np.argmax(moved[first:last]))
        # A frame is shown from its time until the next one's.
        shown = (peak / fps, (peak + 1) / fps)
        late.append(0.0 if shown[0] <= heard <= shown[1] else min(shown[0] - heard, shown[1] - heard, key=abs))
    return late


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        for fps in map(int, sys.argv[2:] or ["24", "30", "60"]):
            late = sync(sys.argv[1], pathlib.Path(name), fps)
            print(f"{fps} fps:", ", ".join(f"{1e3 * l:+.1f} ms" for l in late))
