#!/usr/bin/env python3
"""usage: bench/music/recount.py FOLDER [FPS]     (needs numpy and ffmpeg)

Counts the flashes of the PNG frames that `chladni dance --frames FOLDER` wrote, in luminance and in saturated red, pixel by pixel,
where more than a quarter of the picture flashes together. Written from the text of WCAG 2.3.1 alone, to check the program's count.
"""

import subprocess
import sys

import numpy as np

WIDTH, HEIGHT = 96, 64
PART = 0.25


def linear_frames(folder):
    """Linear colors of all frames."""
    scale = ["-vf", f"scale={WIDTH}:{HEIGHT}:flags=area", "-pix_fmt", "rgb24", "-f", "rawvideo", "-"]
    command = ["ffmpeg", "-v", "error", "-i", f"{folder}/frame-%05d.png", *scale]
    raw = subprocess.run(command, check=True, capture_output=True).stdout
    encoded = np.arange(256) / 255
    table = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return table[np.frombuffer(raw, np.uint8)].reshape(-1, HEIGHT * WIDTH, 3)


def changes(values, counts):
    """Where each pixel completes a change that opposes its last one; `counts` judges the extremes before and after."""
    low, high = values[0].copy(), values[0].copy()
    direction = np.zeros(values.shape[1], int)
    found = np.zeros(values.shape, bool)
    for frame, now in enumerate(values):
        rises = (direction <= 0) & counts(low, now, frame)
        falls = (direction >= 0) & ~rises & counts(now, high, frame)
        found[frame] = changed = rises | falls
        direction = np.where(rises, 1, np.where(falls, -1, direction))
        low = np.where(changed, now, np.minimum(low, now))
        high = np.where(changed, now, np.maximum(high, now))
    return found


def worst(found, fps):
    """The most pairs of changes that more than a quarter of the pixels have within a second."""
    most = 0
    for frame in range(len(found)):
        pairs = found[max(0, frame - int(fps)) : frame + 1].sum(0) // 2
        while (pairs > most).mean() > PART:
            most += 1
    return most


def main():
    fps = float(sys.argv[2]) if len(sys.argv) > 2 else 30.0
    colors = linear_frames(sys.argv[1])
    luminance = colors @ [0.2126, 0.7152, 0.0722]
    excess = 320 * np.maximum(colors[..., 0] - colors[..., 1] - colors[..., 2], 0)
    light = colors.sum(-1)
    saturated = (light > 0) & (colors[..., 0] >= 0.8 * light)
    # A change between two images is one of red where either of them is saturated: those of the last half second are looked at.
    recent = np.stack([saturated[max(0, i - int(fps / 2)) : i + 1].any(0) for i in range(len(saturated))])
    is_general = lambda dark, bright, _: (bright - dark >= 0.1) & (dark < 0.8)  # noqa: E731
    general = worst(changes(luminance, is_general), fps)
    mean = worst(changes(luminance.mean(1, keepdims=True), is_general), fps)
    red = worst(changes(excess, lambda low, high, frame: (high - low > 20) & recent[frame]), fps)
    print(f"luminance {general}, mean {mean}, red {red}")


main()
