"""Signatures and functional maps against their definitions."""

from fractions import Fraction

import chladni
import numpy as np
import pytest
import scipy.sparse


@pytest.fixture(scope="module")
def basis(pebble):
    return chladni.Basis(*pebble, 40)


def test_signatures_are_the_sums_that_they_stand_for(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    times, energies = [0.1, 1.0], [0.5, 2.0, 3.0]
    heat = np.array([[sum(np.exp(-t * w) * h[v] ** 2) for t in times] for v in (0, 100)])
    assert np.allclose(chladni.HKS(w, h, times)[[0, 100]], heat)
    scale = [np.exp(-t * w).sum() for t in times]
    assert np.allclose(chladni.HKS(w, h, times, scaled=True)[[0, 100]], heat / scale)
    weights = np.array([np.exp(-((e - np.log(w[1:])) ** 2) / (2 * 0.3**2)) for e in energies])
    wave = np.array([weights @ h[v, 1:] ** 2 for v in (0, 100)])
    assert np.allclose(chladni.WKS(w, h, energies, 0.3)[[0, 100]], wave)
    assert np.allclose(chladni.WKS(w, h, energies, 0.3, scaled=True)[[0, 100]], wave / weights.sum(axis=1))
    assert chladni.auto_HKS(w, h, 7).shape == chladni.auto_WKS(w, h, 7).shape == (642, 7)
    for bad in (lambda: chladni.HKS(w, h[:, :5], times), lambda: chladni.WKS(w, h, energies, 0)):
        with pytest.raises(chladni.InputError):
            bad()


def test_landmarks_have_signatures_of_their_own(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    low, high = 4 * np.log(10) / w[-1], 4 * np.log(10) / w[1]
    heat = np.exp(-np.outer(np.geomspace(low, high, 3), w))
    sigma = 7 * np.log(w[-1] / w[1]) / 3
    energies = np.linspace(np.log(w[1]) + 2 * sigma, np.log(w[-1]) - 2 * sigma, 3)
    waves = np.exp(-((energies[:, None] - np.log(w[1:])) ** 2) / (2 * sigma**2))
    for signature, weights, vectors in ((chladni.auto_HKS, heat, h), (chladni.auto_WKS, waves, h[:, 1:])):
        exact = np.stack([vectors @ (t * vectors[v]) for v in (7, 100) for t in weights], axis=1)
        assert np.allclose(signature(w, h, 3, [7, 100], False), exact)
        scale = np.tile(weights.sum(axis=1), 2)
        assert np.allclose(signature(w, h, 3, [7, 100]), exact / scale)
        assert np.allclose(signature(w, h, 3, 7, scaled=False), exact[:, :3])
        assert signature(w, h, 3, []).shape == (642, 0)
        # A vertex that is its own landmark has the signature without any.
        assert np.allclose(signature(w, h, 3, [7])[7], signature(w, h, 3)[7])
        for bad in ([642], [-1], [0.0], False, "a", [[1]], [[1], [2, 3]]):
            with pytest.raises(chladni.InputError, match="landmarks"):
                signature(w, h, 3, bad)


def test_only_real_numbers_are_numbers(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    refused = [
        (w, h * 1j, [0.1]),
        (w.astype("U"), h, [0.1]),
        (w, h, np.array(["2020-01-01"], "M8[D]")),
        (w, h, [0.1, "0.2"]),
        (w, h, [None]),
        (w, h, [1 + 2j]),
    ]
    for arguments in refused:
        with pytest.raises(chladni.InputError, match="where real numbers are needed"):
            chladni.HKS(*arguments)
    with pytest.raises(chladni.InputError, match="no array of numbers"):
        chladni.HKS(w, h, [[0.1], [0.2, 0.3]])
    with pytest.raises(chladni.InputError, match="time_list"):
        chladni.HKS(w, h, [10**400])
    assert (chladni.HKS(w, h, [Fraction(1, 2)]) == chladni.HKS(w, h, [0.5])).all()
    for sigma in ("0.3", 0.3 + 1j, np.complex128(0.3), np.datetime64(1, "s"), 10**400, 10**5000):
        with pytest.raises(chladni.InputError, match="sigma is .* where a number is needed"):
            chladni.WKS(w, h, [0.5], sigma)
    for areas in (np.eye(len(h)) * 1j, scipy.sparse.identity(len(h)) * 1j):
        with pytest.raises(chladni.InputError, match="complex128, where real numbers are needed"):
            chladni.p2p_to_FM(np.arange(len(h)), h, h, areas)


def test_flags_and_counts_are_what_they_seem(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    for bad in ([3, 7], "no", np.array([3, 7]), 1):
        for call in (
            lambda bad=bad: chladni.HKS(w, h, [0.1], bad),
            lambda bad=bad: chladni.auto_WKS(w, h, 3, scaled=bad),
            lambda bad=bad: chladni.zoomout_refine(np.eye(4), h, h, return_p2p=bad),
            lambda bad=bad: chladni.icp_refine(np.eye(4), h, h, return_p2p=bad),
        ):
            with pytest.raises(chladni.InputError, match="where True or False is needed"):
                call()
    assert (chladni.HKS(w, h, [0.1], np.True_) == chladni.HKS(w, h, [0.1], True)).all()
    for many in (10**30, 10**400):
        for signature in (chladni.auto_HKS, chladni.auto_WKS):
            with pytest.raises(chladni.InputError, match="num_. is .* where a whole number"):
                signature(w, h, many)


def test_masked_values_are_not_used(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    masked = np.ma.array(h, mask=h > h.max() / 2)
    for call in (
        lambda: chladni.HKS(w, masked, [0.1]),
        lambda: chladni.auto_HKS(w, h, 3, np.ma.array([1, 2], mask=[False, True])),
        lambda: chladni.FM_to_p2p(np.eye(4), masked, h),
    ):
        with pytest.raises(chladni.InputError, match="has masked values"):
            call()
    assert (chladni.HKS(w, np.ma.array(h), [0.1]) == chladni.HKS(w, h, [0.1])).all()


def test_numbers_of_python_are_eigenvectors():
    rows = np.array([[Fraction(1), Fraction(0)], [Fraction(0), Fraction(1)]])
    assert (chladni.FM_to_p2p(np.eye(2), rows, rows[::-1]) == [1, 0]).all()


def test_the_order_of_the_pairs_does_not_matter(basis):
    w, h = basis.eigenvalues, basis.eigenvectors
    order = np.random.default_rng(3).permutation(len(w))
    for signature in (chladni.auto_HKS, chladni.auto_WKS):
        assert np.allclose(signature(w[order], h[:, order], 5), signature(w, h, 5))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_signatures_of_what_is_not_finite_are_refused(basis, bad):
    w, h = basis.eigenvalues, basis.eigenvectors
    bad_w, bad_h = np.append(w[:-1], bad), np.where(np.arange(40) == 7, bad, h)
    refused = [
        ("time_list", lambda: chladni.HKS(w, h, [0.1, bad])),
        ("energy_list", lambda: chladni.WKS(w, h, [0.5, bad], 0.3)),
    ]
    for name, evals, evects in [("evals", bad_w, h), ("evects", w, bad_h)]:
        refused += [
            (name, lambda e=evals, v=evects: chladni.HKS(e, v, [0.1])),
            (name, lambda e=evals, v=evects: chladni.WKS(e, v, [0.5], 0.3)),
            (name, lambda e=evals, v=evects: chladni.auto_HKS(e, v, 3)),
            (name, lambda e=evals, v=evects: chladni.auto_WKS(e, v, 3)),
        ]
    for name, call in refused:
        with pytest.raises(chladni.InputError, match=f"{name} holds NaN or infinity"):
            call()


def test_a_shape_with_other_rows_is_mapped_to_itself(basis):
    h, mass = basis.eigenvectors, basis.mass
    order = np.random.default_rng(2).permutation(len(h))
    other, other_mass = h[order], mass[order]
    for areas in (other_mass, scipy.sparse.diags(other_mass), np.diag(other_mass), None):
        fm = chladni.p2p_to_FM(order, h, other, areas)
        assert np.abs(fm - np.eye(40)).max() < 1e-9
    for adjoint in (False, True):
        assert (chladni.FM_to_p2p(fm, h, other, adjoint) == order).all()
    refined, p2p = chladni.zoomout_refine(np.eye(4), h, other, nit=12, step=3, A2=other_mass, return_p2p=True)
    assert refined.shape == (40, 40) and (p2p == order).all()
    rough = np.eye(40) + 0.05 * np.random.default_rng(3).standard_normal((40, 40))
    for options in (dict(nit=6), dict(nit=6, A2=other_mass, use_adj=True), dict(nit=None)):
        found, p2p = chladni.icp_refine(rough, h, other, return_p2p=True, **options)
        assert np.abs(found - np.eye(40)).max() < 1e-6 and (p2p == order).all()
    narrow = chladni.icp_refine(rough[:12, :20], h, other, nit=2, A2=other_mass)
    assert narrow.shape == (12, 20) and np.abs(narrow @ narrow.T - np.eye(12)).max() < 1e-12
    wide = chladni.zoomout_refine(np.eye(4), h, other, nit=3, step=(1, 2))
    assert wide.shape == (10, 7)
    rows = np.arange(0, len(h), 2)
    inverse = np.argsort(order)
    some = chladni.zoomout_refine(np.eye(20), h, other, nit=4, step=5, subsample=(rows, inverse[rows]))
    assert np.abs(some - np.eye(40)).max() < 1e-6


def test_the_nearest_row_is_found(basis):
    rng = np.random.default_rng(3)
    a, b, fm = rng.normal(size=(300, 8)), rng.normal(size=(200, 6)), rng.normal(size=(6, 8))
    gaps = np.linalg.norm((a @ fm.T)[None] - b[:, None], axis=2)
    assert (chladni.FM_to_p2p(fm, a, b) == gaps.argmin(axis=1)).all()
    gaps = np.linalg.norm(a[None] - (b @ fm)[:, None], axis=2)
    assert (chladni.FM_to_p2p(fm, a, b, use_adj=True) == gaps.argmin(axis=1)).all()
    # So many dimensions that all distances are looked at.
    a, b = rng.normal(size=(700, 60)), rng.normal(size=(600, 60))
    gaps = np.linalg.norm(a[None] - b[:, None], axis=2)
    assert (chladni.FM_to_p2p(np.eye(60), a, b) == gaps.argmin(axis=1)).all()
    a, b = a[:300, :8], b[:200, :6]
    p2p = rng.integers(0, 300, 200)
    assert np.allclose(chladni.p2p_to_FM(p2p, a, b), np.linalg.lstsq(b, a[p2p], rcond=None)[0])
    # Areas need not be symmetric.
    areas = rng.normal(size=(200, 200))
    for given in (areas, scipy.sparse.csr_matrix(areas)):
        assert np.allclose(chladni.p2p_to_FM(p2p, a, b, given), b.T @ areas @ a[p2p])


def test_what_does_not_fit_is_refused(basis):
    h = basis.eigenvectors
    n = len(h)
    refused = [
        lambda: chladni.FM_to_p2p(np.eye(41), h, h),
        lambda: chladni.FM_to_p2p(np.eye(5)[0], h, h),
        lambda: chladni.FM_to_p2p(np.eye(5) * np.nan, h, h),
        lambda: chladni.FM_to_p2p(np.empty((0, 0)), h, h),
        lambda: chladni.FM_to_p2p(np.eye(2), h[:0], h),
        lambda: chladni.p2p_to_FM(np.arange(n) + 1, h, h),
        lambda: chladni.p2p_to_FM(np.arange(n - 1), h, h),
        lambda: chladni.p2p_to_FM(np.arange(n), h, h, np.ones(n - 1)),
        lambda: chladni.p2p_to_FM(np.arange(n), h, h, scipy.sparse.coo_array(np.ones(n))),
        lambda: chladni.p2p_to_FM(scipy.sparse.identity(n), h, h),
        lambda: chladni.p2p_to_FM(np.arange(5), h, h[:5]),
        lambda: chladni.zoomout_refine(np.eye(30), h, h, nit=11),
        lambda: chladni.zoomout_refine(np.eye(30), h, h, nit=2, step=(1, 2, 3)),
        lambda: chladni.zoomout_refine(np.eye(30), h, h, nit=-1),
        lambda: chladni.icp_refine(np.eye(30), h, h, nit=-1),
        lambda: chladni.icp_refine(np.eye(30), h, h, nit=2.5),
        lambda: chladni.icp_refine(np.ones(3), h, h),
        lambda: chladni.zoomout_refine(np.eye(30), h, h, nit=10**18, step=10**18),
    ]
    for i, bad in enumerate(refused):
        with pytest.raises(chladni.InputError):
            print(i, bad())
