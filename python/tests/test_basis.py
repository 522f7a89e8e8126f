"""Bases of meshes."""

import copy
import pickle
import warnings

import chladni
import numpy as np
import pytest


def test_a_sphere_has_the_eigenvalues_of_its_radius(sphere):
    V, F = sphere
    basis = chladni.Basis(3 * V + [10, 0, -4], F, 49)
    degree = np.repeat(np.arange(7), 2 * np.arange(7) + 1)
    assert np.allclose(basis.eigenvalues * 9, degree * (degree + 1), rtol=0.02)
    assert basis.eigenvalues[0] == 0
    assert basis.mass.sum() == pytest.approx(4 * np.pi * 9, rel=2e-3)
    h = basis.eigenvectors
    assert h.shape == (2562, 49) and h.flags.f_contiguous
    assert np.abs(h.T @ (basis.mass[:, None] * h) - np.eye(49)).max() < 1e-10
    S, M = chladni.mesh_laplacian(3 * V + [10, 0, -4], F)
    assert np.allclose(M.diagonal(), basis.mass)
    assert np.abs(S @ h - basis.mass[:, None] * h * basis.eigenvalues).max() < 1e-8
    assert basis.certificate.is_precise and "49 harmonics" in repr(basis)


def test_a_square_is_free_at_its_border(square):
    basis = chladni.Basis(*square, 12)
    exact = np.sort([(i * i + j * j) * np.pi**2 for i in range(6) for j in range(6)])[:12]
    assert np.allclose(basis.eigenvalues, exact, rtol=0.01)


def test_a_square_can_be_held_at_its_border(square):
    V, F = square
    basis = chladni.Basis(3 * V, F, 10, boundary="dirichlet")
    exact = np.sort([(i * i + j * j) * np.pi**2 for i in range(1, 6) for j in range(1, 6)])[:10]
    assert np.allclose(basis.eigenvalues * 9, exact, rtol=0.01)
    on_border = (np.abs(V[:, :2] - 0.5) > 0.499).any(axis=1)
    h = basis.eigenvectors
    assert (h[on_border] == 0).all() and basis.mass.sum() == pytest.approx(9)
    assert np.abs(h.T @ (basis.mass[:, None] * h) - np.eye(10)).max() < 1e-10
    assert basis.certificate.is_precise
    with pytest.raises(chladni.InputError, match="held"):
        chladni.caricature(basis)
    with pytest.raises(chladni.InputError, match="'neumann' or 'dirichlet'"):
        chladni.Basis(V, F, 10, boundary="fixed")
    with pytest.raises(chladni.InputError, match="engine='chladni'"):
        chladni.Basis(V, F, 10, boundary="dirichlet", engine="slepc", ranks=2)


def test_the_vectors_are_handed_over_and_not_copied(ball):
    basis = chladni.Basis(*ball, 5)
    assert basis.eigenvectors is basis.eigenvectors
    assert not basis.eigenvectors.flags.owndata


def test_vertices_in_one_place_share_their_row_and_their_area(ball):
    V, F = ball
    whole = chladni.Basis(V, F, 20)
    # A seam: ten triangles with corners of their own; and a vertex that is not used.
    extra = np.vstack([V, V[F[:10]].reshape(-1, 3), [[9, 9, 9]]])
    apart = F.copy()
    apart[:10] = len(V) + np.arange(30).reshape(10, 3)
    basis = chladni.Basis(extra, apart, 20)
    assert np.allclose(basis.eigenvalues, whole.eigenvalues, rtol=1e-9, atol=1e-12)
    h = basis.eigenvectors
    assert (h[len(V) : -1] == h[F[:10].ravel()]).all()
    assert (h[-1] == 0).all() and basis.mass[-1] == 0
    assert np.abs(h.T @ (basis.mass[:, None] * h) - np.eye(20)).max() < 1e-10


def test_whole_clusters_end_where_eigenvalues_differ(sphere):
    # The three of degree 1 are equal on an icosphere.
    with pytest.warns(chladni.ChladniWarning, match="harmonic 2 .* whole_clusters=True"):
        assert len(chladni.Basis(*sphere, 3).eigenvalues) == 3
    whole = chladni.Basis(*sphere, 3, whole_clusters=True)
    assert len(whole.eigenvalues) == whole.eigenvectors.shape[1] == 4


def test_fewer_harmonics_than_asked_for_are_told():
    # Three vertices in two places each.
    V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0], [0, 0, 1]]
    with pytest.warns(chladni.ChladniWarning, match="4 harmonics instead of 6"):
        basis = chladni.Basis(V, [[0, 1, 2], [3, 4, 5]], 6)
    assert basis.eigenvectors.shape == (6, 4)


def test_a_basis_can_be_pickled_and_copied(ball):
    V, F = ball
    for V, F in (ball, (np.vstack([V, V[:1], [[9, 9, 9]]]), np.vstack([F[1:], np.where(F[:1] == 0, len(V), F[:1])]))):
        basis = chladni.Basis(V, F, 20)
        for again in (pickle.loads(pickle.dumps(basis)), copy.copy(basis), copy.deepcopy(basis)):
            assert type(again) is chladni.Basis and repr(again) == repr(basis)
            for name in ("eigenvalues", "eigenvectors", "mass"):
                assert (getattr(again, name) == getattr(basis, name)).all()
            for name in ("inertia_counts_match", "max_relative_residual", "max_orthogonality_error", "is_precise"):
                assert getattr(again.certificate, name) == getattr(basis.certificate, name)
            assert again.eigenvectors.flags.f_contiguous
            assert (chladni.caricature(again) == chladni.caricature(basis)).all()
    held = pickle.loads(pickle.dumps(chladni.Basis(V, F[5:], 5, boundary="dirichlet")))
    with pytest.raises(chladni.InputError, match="held"):
        chladni.caricature(held)


class Named(chladni.Basis):
    """One with an attribute."""


def test_what_a_subclass_has_besides_is_copied_too(ball):
    basis = Named(*ball, 4)
    basis.name = "ball"
    for again in (pickle.loads(pickle.dumps(basis)), copy.copy(basis), copy.deepcopy(basis)):
        assert type(again) is Named and again.name == "ball"
        assert (again.eigenvectors == basis.eigenvectors).all()


def test_certificates_are_compared_by_their_values(ball):
    certificate = chladni.Basis(*ball, 4).certificate
    again = pickle.loads(pickle.dumps(certificate))
    assert again == certificate and hash(again) == hash(certificate)
    assert certificate != chladni.Basis(*ball, 9).certificate and certificate != 1


def test_what_is_no_mesh_is_refused(ball):
    V, F = ball
    holed = V.copy()
    holed[5, 1] = np.nan
    refused = [
        ((holed, F, 5), "NaN in row 5"),
        ((V + np.inf, F, 5), "inf in row 0"),
        ((V[:, :2], F, 5), r"\(642, 2\)"),
        ((V.ravel(), F, 5), r"\(1926\)"),
        ((V, F[:, :2], 5), r"\(1280, 2\)"),
        ((V, F + 1, 5), "F has 642"),
        ((V, F - 1, 5), "F has -1"),
        ((V, F * 1.0, 5), "whole numbers"),
        ((V + 0j, F, 5), "real numbers"),
        ((V, F, 643), "only 642 harmonics"),
        ((V, F, 10**30), "whole number"),
        ((V, F, 0), "at least 1"),
        ((V, F, "5"), "whole number"),
        (("V", F, 5), "real numbers"),
        (([[1, 2, 3], [4]], F, 5), "no array"),
        ((V, [], 5), "shape"),
        ((V, np.empty((0, 3), int), 5), "no triangle"),
        ((V * 0, F, 5), "triangle|area"),
        ((V * 1e200, F, 5), "too large"),
        ((V * 1e-160, F, 5), "scale it"),
        ((V, F.astype(np.uint64) + np.uint64(2**64 - 13), 5), "F has 1844674407370955160"),
    ]
    for arguments, reason in refused:
        with pytest.raises(chladni.InputError, match=reason):
            chladni.Basis(*arguments)


def test_arrays_of_any_layout_and_number_type_are_taken(ball):
    V, F = ball
    V = np.round(V * 100)
    # Nine end with a group of equal eigenvalues: nothing to warn of.
    values = chladni.Basis(V, F, 9).eigenvalues
    layouts = [
        (np.asfortranarray(V), np.asfortranarray(F)),
        (np.repeat(V, 2, axis=0)[::2], np.repeat(F, 2, axis=1)[:, ::2]),
        (V.astype(np.float32), F.astype(np.uint32)),
        (V.astype(np.int16), F.astype(np.int16)),
        (V.astype(">f8"), F.astype(">i4")),
        (V.tolist(), F.tolist()),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for vertices, faces in layouts:
            assert (chladni.Basis(vertices, faces, 9).eigenvalues == values).all()
