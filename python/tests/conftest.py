"""Small shapes with known answers."""

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# No deadline: machines are slow and shared.
settings.register_profile("chladni", deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("chladni")


def icosphere(subdivisions):
    golden = (1 + 5**0.5) / 2
    corners = [(s * 1, t * golden, 0) for s in (-1, 1) for t in (-1, 1)]
    V = np.array([np.roll(c, r) for r in range(3) for c in corners], dtype=float)
    near = np.linalg.norm(V[:, None] - V[None], axis=2) < 2.1
    F = [(a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[a, c]]
    F = np.array([t if np.linalg.det(V[list(t)]) > 0 else t[::-1] for t in F])
    for _ in range(subdivisions):
        edges = np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, which = np.unique(edges, axis=0, return_inverse=True)
        x, y, z = (len(V) + which.reshape(-1, 3)).T
        a, b, c = F.T
        V = np.vstack([V, V[unique].mean(axis=1)])
        F = np.vstack([np.stack(t, axis=1) for t in ((a, x, z), (b, y, x), (c, z, y), (x, y, z))])
        V /= np.linalg.norm(V, axis=1, keepdims=True)
    return V / np.linalg.norm(V, axis=1, keepdims=True), F


def grid(n):
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    v = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    F = np.vstack([np.stack([v, v + 1, v + n], axis=1), np.stack([v + 1, v + n + 1, v + n], axis=1)])
    return np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1), F


@pytest.fixture(scope="session")
def sphere():
    """2562 vertices."""
    return icosphere(4)


@pytest.fixture(scope="session")
def ball():
    """642 vertices."""
    return icosphere(3)


@pytest.fixture(scope="session")
def square():
    """2500 vertices, with a border."""
    return grid(50)


@pytest.fixture(scope="session")
def pebble(ball):
    """642 vertices, without any symmetry."""
    x, y, z = ball[0].T
    V = np.stack([x * (1.3 + 0.3 * y), y + 0.2 * x * z, 0.8 * z + 0.2 * x * x], axis=1)
    return V, ball[1]


@pytest.fixture(scope="session")
def elements():
    """Stiffness and consistent mass of linear elements, straight from the definition."""
    import scipy.sparse

    def assemble(V, F):
        p = V[F]
        area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
        side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]
        s = np.einsum("fid,fjd->fij", side, side) / (4 * area)[:, None, None]
        m = area[:, None, None] / 12 * (1 + np.eye(3))
        i, j = np.repeat(F, 3, axis=1).ravel(), np.tile(F, 3).ravel()
        n = len(V)
        return [scipy.sparse.csc_matrix((x.ravel(), (i, j)), shape=(n, n)) for x in (s, m)]

    return assemble
