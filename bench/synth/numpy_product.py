"""Times NumPy's matrix product (OpenBLAS, f32) on the shapes of the synthesis.

Usage: numpy_product.py N,K,COLUMNS…   prints one JSON line per shape.
OPENBLAS_NUM_THREADS sets the threads.
"""

import json
import statistics
import sys
import time

import numpy as np

ROUNDS = 15

for shape in sys.argv[1:]:
    n, k, columns = map(int, shape.split(","))
    random = np.random.default_rng(1)
    basis = np.asfortranarray(random.standard_normal((n, k), dtype=np.float32))
    weights = np.asfortranarray(random.standard_normal((k, columns), dtype=np.float32))
    product = np.empty((n, columns), dtype=np.float32, order="F")
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        np.matmul(basis, weights, out=product)
        times.append(1e3 * (time.perf_counter() - start))
    print(json.dumps({"vertices": n, "harmonics": k, "columns": columns, "numpy_ms": statistics.median(times)}))
