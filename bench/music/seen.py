"""Is stereo seen? Films of a shape that dances to a swelling tone in one channel, and how much each half of the picture changes.

Usage: seen.py CHLADNI BODY … [-- OPTIONS OF DANCE]
"""

import pathlib
import subprocess
import sys
import tempfile
import wave

import numpy as np

from sync import decode

RATE, SECS, FPS, SIZE = 44_100, 5, 25, (192, 144)


def tone(path, left, right):
    time = np.arange(SECS * RATE) / RATE
    sound = 0.5 * np.sin(2 * np.pi * 220 * time) * (0.5 - 0.5 * np.cos(2 * np.pi * 1.3 * time))
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.stack([left * sound, right * sound], 1) * 32767).astype("<i2").tobytes())


def halves(chladni, folder, body, left, right, options):
    """Median change from frame to frame of the left and of the right half of the picture; cuts and beats move both at once."""
    song, film = folder / "tone.wav", folder / "tone.mp4"
    tone(song, left, right)
    size = f"{SIZE[0]}x{SIZE[1]}"
    command = [chladni, "--quiet", "dance", str(body), str(song), "-o", str(film), "--size", size, "--fps", str(FPS), *options]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    frames = np.frombuffer(decode(film, "-an", "-f", "rawvideo", "-pix_fmt", "rgb24"), np.uint8)
    frames = frames.reshape(-1, SIZE[1], SIZE[0], 3).astype(float)
    change = np.abs(np.diff(frames, axis=0)).mean((1, 3))
    return np.median(change[:, : SIZE[0] // 2].sum(1)), np.median(change[:, SIZE[0] // 2 :].sum(1))


def seen(chladni, folder, body, options=()):
    """How many times as much the sounding half changes as the other, hard left and hard right. What is at rest changes by nothing;
    a thousandth of a gray level stands for that."""
    hard_left = halves(chladni, folder, body, 1, 0, options)
    hard_right = halves(chladni, folder, body, 0, 1, options)
    least = 1e-3
    return hard_left[0] / max(hard_left[1], least), hard_right[1] / max(hard_right[0], least)


if __name__ == "__main__":
    arguments = sys.argv[2:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    with tempfile.TemporaryDirectory() as name:
        for body in arguments[:split]:
            left, right = seen(sys.argv[1], pathlib.Path(name), body, arguments[split + 1 :])
            print(f"{body}: hard left {left:.1f}, hard right {right:.1f}")
