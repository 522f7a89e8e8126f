"""A surface for benchmarks, of any number of vertices."""

import numpy as np


def torus(m, n, path):
    """A bumpy torus of m × n vertices, no two of whose eigenvalues are equal, as a binary PLY."""
    u, v = np.meshgrid(np.arange(m) * 2 * np.pi / m, np.arange(n) * 2 * np.pi / n, indexing="ij")
    ring = 1 + 0.1 * np.sin(3 * u + 1) + 0.05 * np.cos(2 * v)
    tube = 0.4 * (1 + 0.2 * np.sin(2 * u) * np.cos(3 * v))
    radius = ring + tube * np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.arange(m)[:, None], np.arange(n)[None, :]
    a, b, c, d = (x % m * n + y % n for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    records = np.empty(len(faces), dtype=[("n", "u1"), ("v", "<i4", 3)])
    records["n"], records["v"] = 3, faces
    axes = "".join(f"property double {axis}\n" for axis in "xyz")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {m * n}\n{axes}"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(head.encode() + points.astype("<f8").tobytes() + records.tobytes())
