"""Sections by librosa's agglomerative clustering of beat-synchronous chroma and MFCC, one JSON line per song.

It is told how many sections there are, which nobody tells us: NUMBER SONG NUMBER SONG …
"""
import json
import sys
import time

import librosa
import numpy as np

for count, path in zip(sys.argv[1::2], sys.argv[2::2]):
    samples, rate_hz = librosa.load(path, sr=22050, mono=True)
    start = time.perf_counter()
    _, beats = librosa.beat.beat_track(y=samples, sr=rate_hz)
    chroma = librosa.feature.chroma_cqt(y=samples, sr=rate_hz)
    timbre = librosa.feature.mfcc(y=samples, sr=rate_hz)
    frames = np.vstack([(f - f.mean(1, keepdims=True)) / (f.std(1, keepdims=True) + 1e-9) for f in (chroma, timbre)])
    beats = librosa.util.fix_frames(beats, x_max=frames.shape[1])
    bounds = librosa.segment.agglomerative(librosa.util.sync(frames, beats), int(count))
    times = librosa.frames_to_time(beats[bounds], sr=rate_hz)
    print(json.dumps({"song": path, "sections_secs": list(map(float, times)), "took_secs": time.perf_counter() - start}),
          flush=True)
