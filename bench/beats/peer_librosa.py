"""Beats by librosa's dynamic programming tracker (Ellis 2007), one JSON line per song."""
import json
import sys
import time

import librosa
import numpy as np

for path in sys.argv[1:]:
    samples, rate_hz = librosa.load(path, sr=None, mono=True)
    start = time.perf_counter()
    tempo, beats = librosa.beat.beat_track(y=samples, sr=rate_hz, units="time")
    took = time.perf_counter() - start
    print(json.dumps({"song": path, "tempo_bpm": float(np.atleast_1d(tempo)[0]), "beats_secs": list(map(float, beats)),
                      "took_secs": took}), flush=True)
