"""Functional maps to point maps and back, ZoomOut and ICP, as pyFM has them."""

import numpy as np
import scipy.linalg
import scipy.sparse

from . import _chladni
from ._arguments import count, flag, floats
from ._errors import InputError


def FM_to_p2p(FM_12, evects1, evects2, use_adj=False, n_jobs=None):
    """The point map of a functional map: for each row of ``evects2`` the row of ``evects1`` that it belongs to.

    ``FM_12`` is (k2, k1); of the eigenvectors the first k1 and k2 are used. The nearest neighbor is exact, the first of
    several that are equally near. ``n_jobs`` is taken for the sake of calls that have it: all cores are used.
    """
    return _chladni.fm_to_p2p(FM_12, evects1, evects2, use_adj)


def p2p_to_FM(p2p_21, evects1, evects2, A2=None):
    """The functional map (k2, k1) of a point map: evects2ᵀ A2 evects1[p2p_21] with the target's areas ``A2``, (n2,) or
    (n2, n2), or the least-squares solution without them."""
    if scipy.sparse.issparse(p2p_21):
        raise InputError("p2p_21 is a sparse matrix, where a vertex for each row of evects2 is needed")
    return _chladni.p2p_to_fm(p2p_21, evects1, evects2, _dual(A2, evects2))


def zoomout_refine(
    FM_12,
    evects1,
    evects2,
    nit=10,
    step=1,
    A2=None,
    subsample=None,
    return_p2p=False,
    n_jobs=None,
    verbose=False,
    *,
    progress=None,
):
    """Refines a functional map by ZoomOut: ``nit`` times to a point map and back with ``step`` more eigenvectors.

    ``step`` is a number or (of shape 1, of shape 2), ``subsample`` the rows of both shapes to work on. Returns the map of
    (k2 + nit·step, k1 + nit·step), and its point map on all rows if ``return_p2p``. ``n_jobs`` and ``verbose`` are taken
    for the sake of calls that have them; ``progress`` is called with (stage, done, total).
    """
    return_p2p = flag(return_p2p, "return_p2p")
    steps = tuple(step) if np.iterable(step) else (step, step)
    if len(steps) != 2:
        raise InputError(f"step has {len(steps)} values, where one or two are needed")
    if subsample is None:
        source, target, dual = evects1, evects2, _dual(A2, evects2)
    else:
        source, target = _sampled(subsample, floats(evects1, "evects1"), floats(evects2, "evects2"))
        dual = None
    refined = _chladni.zoomout(FM_12, source, target, dual, nit, steps, progress)
    return (refined, FM_to_p2p(refined, evects1, evects2)) if return_p2p else refined


def icp_refine(
    FM_12,
    evects1,
    evects2,
    nit=10,
    tol=1e-10,
    use_adj=False,
    return_p2p=False,
    n_jobs=None,
    verbose=False,
    *,
    A2=None,
):
    """Refines a functional map (k2, k1) by ICP: ``nit`` times to a point map and back, to the nearest map whose singular
    values are 1.

    Without ``nit``, None or 0, it goes on until no value changes by more than ``tol``, or 10,000 times. Returns the map, and
    its point map if ``return_p2p``. ``A2`` as in :func:`p2p_to_FM`; ``n_jobs`` and ``verbose`` are taken for the sake of
    calls that have them.
    """
    return_p2p = flag(return_p2p, "return_p2p")
    refined = floats(FM_12, "FM_12")
    evects1, evects2 = floats(evects1, "evects1"), floats(evects2, "evects2")
    if refined.ndim != 2 or evects1.ndim != 2 or evects2.ndim != 2:
        raise InputError("FM_12, evects1 and evects2 are needed as tables of two dimensions")
    rounds = count(nit, "nit") if nit else 10_000
    k2, k1 = refined.shape
    source, target = evects1[:, :k1], evects2[:, :k2]
    dual = _dual(A2, target)
    for _ in range(rounds):
        p2p = FM_to_p2p(refined, evects1, evects2, use_adj)
        left, _, right = scipy.linalg.svd(_chladni.p2p_to_fm(p2p, source, target, dual))
        before, refined = refined, left @ np.eye(k2, k1) @ right
        if not nit and np.abs(refined - before).max() <= tol:
            break
    return (refined, FM_to_p2p(refined, evects1, evects2, use_adj)) if return_p2p else refined


def _sampled(subsample, evects1, evects2):
    try:
        rows1, rows2 = subsample
    except (TypeError, ValueError):
        raise InputError("subsample is not a pair of rows of shape 1 and rows of shape 2") from None
    try:
        return evects1[np.asarray(rows1)], evects2[np.asarray(rows2)]
    except (IndexError, TypeError, ValueError) as error:
        raise InputError(f"subsample names rows that are not there: {error}") from None


def _dual(A2, evects2):
    """A2ᵀ evects2, the transpose of which is applied."""
    if A2 is None:
        return None
    areas = A2 if scipy.sparse.issparse(A2) and A2.ndim == 2 else floats(A2, "A2")
    evects2 = floats(evects2, "evects2")
    if areas.ndim not in (1, 2) or evects2.ndim != 2 or areas.shape != (len(evects2),) * areas.ndim:
        raise InputError(f"A2 has the shape {areas.shape}, evects2 {evects2.shape}: they do not belong together")
    return areas[:, None] * evects2 if areas.ndim == 1 else areas.T @ evects2
