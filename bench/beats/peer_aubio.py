"""Beats by aubio's causal tracker (Davies and Plumbley 2007), one JSON line per song."""
import json
import subprocess
import sys
import time

import aubio
import numpy as np

RATE_HZ, WINDOW, HOP = 44100, 1024, 512

for path in sys.argv[1:]:
    decoded = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-ac", "1", "-ar", str(RATE_HZ), "-f", "f32le", "-"],
                             capture_output=True, check=True).stdout
    samples = np.frombuffer(decoded, dtype=np.float32)
    start = time.perf_counter()
    tracker = aubio.tempo("default", WINDOW, HOP, RATE_HZ)
    beats = [tracker.get_last_s() for at in range(0, len(samples) - HOP + 1, HOP) if tracker(samples[at:at + HOP])]
    took = time.perf_counter() - start
    print(json.dumps({"song": path, "tempo_bpm": tracker.get_bpm(), "beats_secs": list(map(float, beats)),
                      "took_secs": took}), flush=True)
