"""Eigenpairs against closed forms and SciPy."""

import math
import tracemalloc
from fractions import Fraction

import chladni
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from chladni import spectrum


def gram(v, M):
    return v.T @ (M @ v)


def same_subspaces(w, v, v_other, M):
    """Eigenvectors of every group of equal eigenvalues span the same space."""
    ends = [i for i in range(1, len(w)) if w[i] - w[i - 1] > 1e-6 * w[i]]
    for first, end in zip([0, *ends], ends, strict=False):
        overlap = v[:, first:end].T @ (M @ v_other[:, first:end])
        assert np.allclose(np.linalg.svd(overlap, compute_uv=False), 1, atol=1e-7)


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
def test_finite_elements_agree_with_scipy(sphere, square, elements, mass):
    for V, F in (sphere, square):
        S, M = elements(V, F)
        if mass == "lumped":
            M = scipy.sparse.diags(np.asarray(M.sum(axis=1)).ravel())
        w, v, certificate = chladni.eigsh(S, 60, M, sigma=-0.01, return_certificate=True)
        assert certificate.is_precise and certificate.inertia_counts_match
        assert v.flags.f_contiguous and v.shape == (len(V), 60)
        assert np.abs(gram(v, M) - np.eye(60)).max() < 1e-9
        assert np.abs(S @ v - M @ v * w).max() < 1e-8 * w[-1] * np.abs(M @ v).max()
        peer, peer_v = scipy.sparse.linalg.eigsh(S, 60, M.tocsc(), sigma=-0.01, tol=1e-12)
        assert np.allclose(w, peer, rtol=1e-9, atol=1e-9)
        same_subspaces(w, v, peer_v, M)
        assert w[0] == 0


def test_rows_need_not_sum_to_zero_and_m_may_be_left_out():
    n = 400
    held = scipy.sparse.diags([2.0 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1])
    w = chladni.eigsh(held, 20, which="SM", return_eigenvectors=False)
    exact = 2 - 2 * np.cos(np.pi * np.arange(1, 21) / (n + 1))
    assert np.allclose(w, exact, rtol=0, atol=1e-13)
    # Dense, integer, and all of it.
    small = held.toarray()[:40, :40].astype(int)
    small_w, v = chladni.eigsh(small, 40, sigma=0)
    assert np.allclose(small_w, scipy.linalg.eigh(small)[0], atol=1e-12)
    assert np.abs(gram(v, np.eye(40)) - np.eye(40)).max() < 1e-10


def test_a_null_space_may_have_any_dimension(ball, elements):
    S, M = elements(*ball)
    S3, M3 = (scipy.sparse.block_diag([A] * 3) for A in (S, M))
    w = chladni.eigsh(S3, 30, M3, sigma=-1e-3)[0]
    one = chladni.eigsh(S, 10, M, sigma=-1e-3)[0]
    assert (w[:3] == 0).all() and np.allclose(w, np.repeat(one, 3), rtol=1e-9)


def test_matrices_may_be_unsorted_and_of_any_sparse_kind(ball, elements):
    S, M = elements(*ball)
    w = chladni.eigsh(S, 10, M, sigma=0, return_eigenvectors=False)
    shuffled = S.tocoo()
    order = np.random.default_rng(1).permutation(shuffled.nnz)
    entries = (shuffled.data[order], (shuffled.row[order], shuffled.col[order]))
    for kind in ("csr", "coo", "lil", "dok"):
        again = scipy.sparse.coo_matrix(entries, shape=S.shape).asformat(kind)
        assert np.allclose(chladni.eigsh(again, 10, M, sigma=0)[0], w, rtol=1e-10)
    array = scipy.sparse.csr_array(S)
    assert np.allclose(chladni.eigsh(array, 10, scipy.sparse.csr_array(M), sigma=0)[0], w, rtol=1e-10)


def test_the_number_of_threads_changes_nothing(square, elements):
    S, M = elements(*square)
    one, two = (chladni.eigsh(S, 100, M, sigma=0, threads=t) for t in (1, 2))
    assert (one[0] == two[0]).all() and (one[1] == two[1]).all()


def test_what_is_not_asked_of_this_solver_is_refused(ball, elements):
    S, M = elements(*ball)
    identity = scipy.sparse.identity(S.shape[0])
    refused = [
        (dict(), "asks for other pairs"),
        (dict(sigma=0, which="SM"), "asks for other pairs.*which='LM' with it"),
        (dict(sigma=1e-8, which="LA"), "asks for other pairs"),
        (dict(which="BE"), "asks for other pairs"),
        (dict(sigma=0, mode="buckling"), "buckling"),
        (dict(sigma=11.0), "lies among the eigenvalues"),
        (dict(sigma="0"), "where a number is needed"),
        (dict(sigma=10**400), "where a number is needed"),
        (dict(sigma=0, tol=10**400), "tol is a long int"),
        (dict(sigma=0, k=0), "at least 1"),
        (dict(sigma=0, k=10**12), "only 642 eigenvalues"),
        (dict(sigma=0, k=2.5), "whole number"),
        (dict(sigma=0, k=2**63), r"below 2\*\*63"),
        (dict(sigma=0, return_eigenvectors="no"), "True or False"),
        (dict(sigma=0, return_certificate=2), "True or False"),
        (dict(sigma=0, M=M[:5, :5]), "rows"),
        (dict(sigma=0, M=-M), "not positive"),
        (dict(sigma=0, M=M - 0.9 * M.diagonal().min() * identity), "not positive definite"),
        (dict(sigma=0, A=S - identity), "negative eigenvalues"),
        (dict(sigma=0, A=S[:, :5]), "square"),
        (dict(sigma=0, A=S[:5]), "square"),
        (dict(sigma=0, A=scipy.sparse.triu(S)), "not symmetric"),
        (dict(sigma=0, A=S * np.nan), "nan"),
        (dict(sigma=0, A=S * 1j), "complex128"),
        (dict(sigma=0, A=None), "A"),
        (dict(sigma=0, A=scipy.sparse.coo_array(np.ones(4))), "A has (1 dimensions|the shape)"),
        (dict(sigma=0, A=-S), "^S has .*-S is what"),
        (dict(sigma=0, A=scipy.sparse.linalg.aslinearoperator(S)), "LinearOperator"),
        (dict(sigma=0, tol="a"), "tol is 'a'"),
        (dict(sigma=0, threads=0), "threads"),
        (dict(sigma=0, threads=10**6), "1000000 threads: at most 1024"),
    ]
    for change, reason in refused:
        arguments = dict(A=S, k=12, M=M) | change
        with pytest.raises(chladni.InputError, match="(?i)" + reason):
            print(change, chladni.eigsh(**arguments))
    # A sigma as small as rounding is at the smallest; one far below, too.
    for sigma in (1e-8, -100):
        assert chladni.eigsh(S, 12, M, sigma=sigma)[0][0] == 0
    for sigma in (0, -1):
        assert chladni.eigsh(S, 12, M, sigma=sigma, which="LA")[0][0] == 0
    with pytest.raises(chladni.NotCertifiedError, match="tol"):
        chladni.eigsh(S, 12, M, sigma=0, tol=1e-300)
    assert chladni.eigsh(S, 12, M, sigma=0, tol=1e-9)[0][0] == 0


def test_tol_is_of_small_eigenvalues_too():
    # Rounding alone is 10⁻⁷ of the first eigenvalue, and 10⁻¹⁵ of the largest.
    n = 20
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((n, n)))[0]
    A = turn @ np.diag([1e-8, *range(1, n)]) @ turn.T
    A = 0.5 * (A + A.T)
    assert chladni.eigsh(A, 3, sigma=0, tol=1e-2)[0][0] == pytest.approx(1e-8, rel=1e-3)
    with pytest.raises(chladni.NotCertifiedError, match="relative residual"):
        chladni.eigsh(A, 3, sigma=0, tol=1e-11)


def test_residuals_of_many_pairs_take_less_memory_than_their_vectors():
    n, k = 2000, 200
    w, v = np.arange(1.0, k + 1), np.eye(n, k, order="F")
    A = scipy.sparse.diags(np.arange(1.0, n + 1)).tocsc()
    a = spectrum._columns(A, "A")
    tracemalloc.start()
    assert spectrum._largest_residual(a, None, w, v) == 0
    assert tracemalloc.get_traced_memory()[1] < v.nbytes
    tracemalloc.stop()
    w[20] *= 1.5
    assert spectrum._largest_residual(a, None, w, v) == pytest.approx(0.5)
    v[0, 20] = math.nan
    assert math.isnan(spectrum._largest_residual(a, None, w, v))


def test_the_laplacian_of_a_mesh(sphere, square):
    for V, F in (sphere, square):
        S, M = chladni.mesh_laplacian(5 * V + 1, F)
        assert np.abs(S @ np.ones(len(V))).max() < 1e-12
        assert (S - S.T).nnz == 0 and (S - scipy.sparse.diags(S.diagonal())).max() <= 0
        p = 5 * V[F]
        area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
        assert M.sum() == pytest.approx(area)
    # x is linear on a square: no tension inside.
    inside = (np.abs(square[0][:, :2] - 0.5) < 0.49).all(axis=1)
    assert np.abs(chladni.mesh_laplacian(*square)[0] @ square[0][:, 0])[inside].max() < 1e-12


def test_a_vertex_that_is_not_used_is_in_nobody_s_way(ball):
    V, F = ball
    S, M = chladni.mesh_laplacian(np.vstack([V, [[7, 7, 7]]]), F)
    assert S.format == M.format == "csc" and S.shape == (643, 643)
    assert S[642].sum() == S[642, 642] == 1 and M[642, 642] == pytest.approx(1e-3 * M.diagonal()[:642].min())
    alone, areas = chladni.mesh_laplacian(V, F)
    assert abs(S[:642, :642] - alone).max() < 1e-12
    assert np.allclose(chladni.eigsh(S, 9, M, sigma=-0.01)[0], chladni.eigsh(alone, 9, areas, sigma=-0.01)[0])


def test_matrices_unlike_those_of_surfaces():
    rng = np.random.default_rng(0)
    for n in (402, 500):
        A, B = (X @ X.T + n * np.eye(n) for X in rng.standard_normal((2, n, n)))
        assert np.allclose(chladni.eigsh(A, 5, sigma=0)[0], scipy.linalg.eigvalsh(A)[:5], rtol=1e-9)
        assert np.allclose(chladni.eigsh(A, 5, B, sigma=0)[0], scipy.linalg.eigvalsh(A, B)[:5], rtol=1e-9)
    assert np.allclose(chladni.eigsh(np.eye(9, dtype=bool), 2, sigma=0)[0], 1, rtol=1e-14)
    many = scipy.sparse.diags(np.r_[np.zeros(3000), np.arange(2000.0)])
    w, v = chladni.eigsh(many, 7, sigma=0)
    assert (w == 0).all() and v.shape == (5000, 7) and np.abs(many @ v).max() < 1e-9
    # All of the eigenvalues, wherever sigma lies.
    assert len(chladni.eigsh(np.diag([1.0, 2.0, 3.0]), 3, sigma=2.1)[0]) == 3


def test_dense_matrices_may_hold_any_real_numbers():
    A = np.array([[2, -1], [-1, 2]])
    fractions = np.array([[Fraction(a) for a in row] for row in A.tolist()])
    for given in (A.astype("f2"), A.astype(">i4"), A.astype(">f8"), fractions):
        assert chladni.eigsh(given, 1, sigma=0)[0] == pytest.approx(1)
        assert chladni.eigsh(np.eye(2), 1, given, sigma=0)[0] == pytest.approx(1 / 3)


def test_masked_entries_are_not_used(ball):
    V, F = ball
    for bad in (
        lambda: chladni.eigsh(np.ma.array(np.eye(3), mask=np.eye(3) > 0), 1, sigma=0),
        lambda: chladni.mesh_laplacian(np.ma.array(V, mask=V > 0.9), F),
        lambda: chladni.mesh_laplacian(V, np.ma.array(F, mask=F == 7)),
        lambda: chladni.mesh_laplacian(V, np.ma.array(F, mask=F == 7, dtype="u8")),
    ):
        with pytest.raises(chladni.InputError, match="has masked values"):
            bad()


def test_points_without_triangles_have_a_laplacian(sphere):
    V = 2 * sphere[0] + [5, 0, 0]
    S, M = chladni.point_cloud_laplacian(V)
    assert np.abs(S @ np.ones(len(V))).max() < 1e-12 and (S - S.T).nnz == 0
    assert M.sum() == pytest.approx(16 * np.pi, rel=0.01)
    degree = np.repeat(np.arange(4), 2 * np.arange(4) + 1)
    assert np.allclose(chladni.eigsh(S, 16, M, sigma=0)[0] * 4, degree * (degree + 1), rtol=0.02, atol=1e-6)
    with pytest.raises(chladni.InputError, match="one line"):
        chladni.point_cloud_laplacian(np.arange(30)[:, None] * [1.0, 2.0, 3.0])
    with pytest.raises(chladni.InputError, match="n_neighbors"):
        chladni.point_cloud_laplacian(V, n_neighbors=1)
    few = V[::9]
    for all_and_more in (10**6, 10**15):
        S, M = chladni.point_cloud_laplacian(few, n_neighbors=all_and_more)
        assert (S != chladni.point_cloud_laplacian(few, n_neighbors=len(few) - 1)[0]).nnz == 0


def test_a_held_border_is_rows_and_columns_left_out(square, elements):
    V, F = square
    inside = np.flatnonzero((np.abs(V[:, :2] - 0.5) < 0.499).all(axis=1))
    free = inside
    S, M = chladni.mesh_laplacian(V, F)
    w = chladni.eigsh(S[free][:, free], 10, M[free][:, free], sigma=0)[0]
    assert np.allclose(w, chladni.Basis(V, F, 10, boundary="dirichlet").eigenvalues, rtol=1e-8)
    S, M = (A[inside][:, inside] for A in elements(V, F))
    w, v = chladni.eigsh(S, 10, M, sigma=0)
    exact = np.sort([(i * i + j * j) * np.pi**2 for i in range(1, 6) for j in range(1, 6)])[:10]
    assert np.allclose(w, exact, rtol=0.02) and w[0] > 0
    # The first is a sine either way, of norm 1.
    first = 2 * np.sin(np.pi * V[inside, 0]) * np.sin(np.pi * V[inside, 1])
    assert np.abs(v[:, 0] - first).max() < 0.02
