"""Spectral signatures, as pyFM has them."""

import numpy as np

from ._arguments import count, finite, flag, number, refuse_masked
from ._errors import InputError


def HKS(evals, evects, time_list, scaled=False):
    """Heat kernel signature, (n, times): Σ_k exp(-t λ_k) φ_k(v)², over Σ_k exp(-t λ_k) where ``scaled``."""
    evals, evects = _pairs(evals, evects)
    return _heat(evals, evects, finite(time_list, "time_list").ravel(), None, scaled)


def WKS(evals, evects, energy_list, sigma, scaled=False):
    """Wave kernel signature, (n, energies): Σ_k exp(-(e - log λ_k)² / 2σ²) φ_k(v)², over the sum of the weights where
    ``scaled``. Pairs of an eigenvalue of 1e-8 of the largest or less are left out."""
    evals, evects = _pairs(evals, evects)
    sigma = number(sigma, "sigma")
    if not sigma > 0:
        raise InputError(f"sigma is {sigma}, where a number above 0 is needed")
    return _waves(evals, evects, finite(energy_list, "energy_list").ravel(), sigma, None, scaled)


def auto_HKS(evals, evects, num_T, landmarks=None, scaled=True):
    """HKS at ``num_T`` times between 4 ln 10 / λ_K and 4 ln 10 / λ_2, evenly in their logarithm.

    With p vertices as ``landmarks`` (n, p * num_T): φ_k(v) φ_k(l) in place of φ_k(v)², all times of one landmark l after
    those of another.
    """
    evals, evects = _sorted_pairs(evals, evects)
    _check_several(evals)
    low, high = 4 * np.log(10) / evals[-1], 4 * np.log(10) / evals[1]
    return _heat(evals, evects, np.geomspace(low, high, count(num_T, "num_T")), landmarks, scaled)


def auto_WKS(evals, evects, num_E, landmarks=None, scaled=True):
    """WKS at ``num_E`` energies, evenly from log λ_2 + 2σ to log λ_K - 2σ, with the width
    σ = 7 (log λ_K - log λ_2) / num_E; ``landmarks`` as in `auto_HKS`."""
    evals, evects = _sorted_pairs(evals, evects)
    _check_several(evals)
    num_E = count(num_E, "num_E")
    low, high = np.log(evals[1]), np.log(evals[-1])
    sigma = 7 * (high - low) / num_E
    energies = np.linspace(low + 2 * sigma, high - 2 * sigma, num_E)
    return _waves(evals, evects, energies, sigma, landmarks, scaled)


def _pairs(evals, evects):
    evals, evects = finite(evals, "evals").ravel(), finite(evects, "evects")
    if evects.ndim != 2 or evects.shape[1] != len(evals) or len(evals) == 0:
        raise InputError(f"eigenvectors of the shape {evects.shape} do not belong to {len(evals)} eigenvalues")
    return evals, evects


def _sorted_pairs(evals, evects):
    """The pairs by their |eigenvalue|, the smallest first."""
    evals, evects = _pairs(evals, evects)
    evals = np.abs(evals)
    order = np.argsort(evals, kind="stable")
    return evals[order], evects[:, order]


def _check_several(evals):
    if len(evals) < 3 or not evals[1] > 0:
        raise InputError("at least three pairs are needed, of which only the first has an eigenvalue of 0")


def _heat(evals, evects, times, landmarks, scaled):
    return _summed(np.exp(-np.outer(times, evals)), evects, landmarks, scaled)


def _waves(evals, evects, energies, sigma, landmarks, scaled):
    waving = evals > 1e-8 * evals.max()
    weights = np.exp(-np.square(energies[:, None] - np.log(evals[waving])) / (2 * sigma**2))
    return _summed(weights, evects[:, waving], landmarks, scaled)


def _summed(weights, evects, landmarks, scaled):
    if flag(scaled, "scaled"):
        weights = weights / weights.sum(axis=1, keepdims=True)
    if landmarks is None:
        return np.square(evects) @ weights.T
    at = evects[_vertices(landmarks, len(evects)), None]
    return evects @ (at * weights).reshape(-1, evects.shape[1]).T


def _vertices(landmarks, n):
    """One or several ``landmarks`` as vertices below n."""
    refuse_masked(landmarks, "landmarks")
    try:
        vertices = np.atleast_1d(landmarks)
    except ValueError as error:
        raise InputError(f"landmarks is no array: {error}") from None
    # An empty list is an array of floats.
    is_whole = vertices.dtype.kind in ("iu" if vertices.size else "fiu")
    if vertices.ndim > 1 or not is_whole or ((vertices < 0) | (vertices >= n)).any():
        raise InputError(f"landmarks are to be whole numbers from 0 and below {n}, the number of vertices")
    return vertices.astype(int)
