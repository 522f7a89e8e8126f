"""Reads an exported operator and measures eigenpairs against it, the same way for every peer."""

import json

import numpy as np


class Operator:
    """S in compressed columns (symmetric, so rows too) and the lumped areas a of S h = λ a h."""

    def __init__(self, stiffness_path, basis_path):
        with np.load(stiffness_path) as s:
            self.data, self.indices, self.indptr = s["data"], s["indices"], s["indptr"]
        with np.load(basis_path) as b:
            self.mass = b["mass"]
        self.n = len(self.mass)
        # The unit of area is the surface's own mean, so that shifts mean the same for every mesh.
        self.unit = self.mass.sum() / (4 * np.pi)
        self.mass = self.mass / self.unit

    def times(self, x):
        rows = np.repeat(np.arange(self.n), np.diff(self.indptr))
        out = np.empty_like(x)
        for k in range(x.shape[1]):
            out[:, k] = np.bincount(rows, self.data * x[self.indices, k], minlength=self.n)
        return out


def report(operator, values, vectors, seconds, **more):
    """Prints one JSON line: residual and orthogonality of M-orthonormal `vectors` (n × k)."""
    order = np.argsort(values)
    values, vectors = values[order], vectors[:, order]
    residual = 0.0
    for first in range(0, len(values), 64):
        part = slice(first, first + 64)
        image = operator.times(vectors[:, part])
        error = image - operator.mass[:, None] * vectors[:, part] * values[part]
        size = np.linalg.norm(image, axis=0)
        # λ = 0 has no relative residual.
        nonzero = values[part] > 1e-7
        if nonzero.any():
            residual = max(residual, (np.linalg.norm(error, axis=0) / size)[nonzero].max())
    orthogonality = 0.0
    for first in range(0, len(values), 256):
        part = vectors[:, first : first + 256] * operator.mass[:, None]
        gram = part.T @ vectors
        gram[np.arange(gram.shape[0]), first + np.arange(gram.shape[0])] -= 1
        orthogonality = max(orthogonality, np.abs(gram).max())
    print(json.dumps(dict(seconds=seconds, residual=residual, orthogonality=orthogonality,
                          count=len(values), last=values[-1] / operator.unit, **more)))
