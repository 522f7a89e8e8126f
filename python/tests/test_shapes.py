"""Geodesics, matches, caricatures, symmetry and files."""

import copy
import errno
import os
import pickle
import warnings
from pathlib import Path

import chladni
import numpy as np
import pytest


def test_distances_on_a_sphere_and_in_a_plane(sphere, square):
    V, F = sphere
    solver = chladni.MeshHeatMethodDistanceSolver(7 * V, F)
    found = solver.compute_distance(5)
    exact = 7 * np.arccos(np.clip(V @ V[5], -1, 1))
    assert found[5] == 0 and np.abs(found - exact).max() < 7 * 0.05
    both = solver.compute_distance_multisource([5, 70])
    assert np.abs(both - np.minimum(exact, 7 * np.arccos(np.clip(V @ V[70], -1, 1)))).max() < 7 * 0.08
    # A patch is 0, whatever the number of its sources.
    cap = np.flatnonzero(V[:, 2] > 0.5)
    exact = 7 * np.arccos(np.clip((V @ V[cap].T).max(axis=1), -1, 1))
    assert np.abs(solver.compute_distance_multisource(cap) - exact).max() < 7 * 0.05
    V, F = square
    exact = np.linalg.norm(V - V[0], axis=1)
    assert np.abs(chladni.compute_distance(V, F, 0) - exact).max() < 0.04
    assert np.isinf(chladni.compute_distance(np.vstack([V, [[5, 5, 5]]]), F, 0)[-1])
    for bad in (-1, len(V), 2.5, "0", [], [[0]]):
        with pytest.raises(chladni.InputError):
            chladni.compute_distance_multisource(V, F, bad)
    for arguments in ((0,), (-1,), (np.nan,), (1e14,), (1, False), (1, "no")):
        with pytest.raises(chladni.InputError):
            chladni.MeshHeatMethodDistanceSolver(V, F, *arguments)


def test_a_match_with_a_moved_self_finds_the_motion(pebble):
    V, F = pebble
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    moved = 2.5 * V @ turn.T + [1, 2, 3]
    found = chladni.match(V, F, moved, F, method="icp")
    assert (found.p2p == np.arange(len(V))).mean() > 0.99
    assert np.abs(found.targets - V).max() < 1e-3 and np.abs(found.points - moved).max() < 1e-3
    ones = np.hstack([moved, np.ones((len(V), 1))])
    assert np.allclose((ones @ found.transform.T)[:, :3], V, atol=1e-3)
    assert np.allclose(found.weights.sum(axis=1), 1) and found.coverage > 0.99
    assert 0 <= found.residual_median <= found.residual_p95 < 1e-3 and found.strongly_stretched == 0
    landmarks = [[0, 0], [10, 10], [100, 100], [300, 300]]
    led = chladni.match(V, F, moved, F, landmarks)
    assert np.abs(led.targets - V).max() < 0.05
    same = chladni.match(V, F, moved, F, method="same")
    assert (same.p2p == np.arange(len(V))).all() and np.abs(same.targets - V).max() < 1e-9
    assert same.residual_median is None and same.residual_p95 is None
    for none in ([], np.empty((0, 2), int)):
        assert (chladni.match(V, F, moved, F, none, method="same").p2p == same.p2p).all()
    with pytest.warns(chladni.ChladniWarning, match="look inward"):
        assert chladni.match(V, F[:, ::-1], moved, F, method="icp").coverage > 0.99
    for bad in (dict(landmarks=[[0, 10**6]]), dict(landmarks=[[0.5, 1]]), dict(landmarks=[1, 2]), dict(method="x")):
        with pytest.raises(chladni.InputError):
            chladni.match(V, F, moved, F, **bad)
    with pytest.raises(chladni.InputError, match="V2"):
        chladni.match(V, F, moved * np.nan, F)


def test_a_caricature_exaggerates_what_is_different(pebble):
    V, F = pebble
    basis = chladni.Basis(V, F, 60)
    assert np.allclose(chladni.caricature(basis, mu=0), V, atol=1e-12)
    # μ = 1 takes the coordinate model to the template, as far as 60 harmonics and the match go.
    scale = np.linalg.norm(V - V.mean(axis=0), axis=1).mean()
    away, toward = (chladni.caricature(basis, mu=mu) - V for mu in (-0.5, 0.5))
    assert np.allclose(away, -toward, atol=1e-9) and np.linalg.norm(away, axis=1).max() > 0.02 * scale
    assert np.allclose(chladni.caricature(V, F, k=60), V + away, atol=1e-9)
    for model in ("coordinate", "normal", "distance"):
        for template in ("sphere", 10, (V[:, [1, 0, 2]] * [1, -1, 1.2], F)):
            moved = chladni.caricature(basis, template=template, model=model, method="icp")
            assert moved.shape == V.shape and np.isfinite(moved).all()
    # Without its finest detail, in which a match is rough; vertices that belong together have no such detail.
    other = (V * [1, 1, 1.2], F)
    for method in ("icp", "same"):
        away, toward = (chladni.caricature(basis, template=other, mu=mu, method=method) - V for mu in (-0.5, 0.5))
        assert np.allclose(away, -toward, atol=1e-9) == (method == "same")
    found = chladni.match(V, F, *other, method="same")
    assert np.allclose(chladni.caricature(basis, template=other, mu=1, method="same"), found.targets, atol=1e-12)
    by = [chladni.caricature(basis, template=other, model=m, method="same") for m in ("coordinate", "normal", "distance")]
    assert min(np.abs(a - b).max() for a, b in zip(by, by[1:] + by[:1])) > 1e-3
    # A template of ten harmonics has no others, and a sphere one radius.
    low = chladni.caricature(basis, template=10, mu=1)
    amplitudes = np.abs(basis.eigenvectors.T @ (basis.mass[:, None] * low))
    assert amplitudes[10:].max() < 1e-9 < 1e-3 < amplitudes[9].max()
    round_ = chladni.caricature(basis, template="sphere", mu=1)
    terms = np.hstack([2 * round_, np.ones((len(V), 1))])
    center = np.linalg.lstsq(terms, (round_**2).sum(axis=1), rcond=None)[0][:3]
    assert np.ptp(np.linalg.norm(round_ - center, axis=1)) < 1e-9
    pair = (V * 1.1, F)
    assert (chladni.caricature(basis, template=list(pair)) == chladni.caricature(basis, template=pair)).all()
    templates = [dict(template=bad) for bad in ("x", -3, 61)]
    for bad in (dict(mu=np.nan), dict(mu=1000), dict(model="x"), *templates, dict(F=F)):
        with pytest.raises(chladni.InputError):
            chladni.caricature(basis, **bad)


def test_a_mirror_tells_harmonics_apart(ball):
    V, F = ball
    V = V * [1.0, 1.3, 1.7] + [0.05, 0, 0] * np.sin(2 * V[:, 1:2] + V[:, 2:]) * np.sign(V[:, :1])
    basis = chladni.Basis(V, F, 20)
    found = chladni.symmetry(basis)
    assert set(np.unique(found.classes)) == {-1, 1} and found.classes[0] == 1
    h = found.eigenvectors
    assert np.abs(h.T @ (basis.mass[:, None] * h) - np.eye(20)).max() < 1e-9
    # The mirror image of each vertex is the nearest vertex to it.
    image = V - 2 * np.outer(V @ found.normal - found.offset, found.normal)
    other = np.linalg.norm(V[None] - image[:, None], axis=2).argmin(axis=1)
    products = np.einsum("v,vk,vk->k", basis.mass, h, h[other])
    assert (np.sign(products) == found.classes).all()


def test_what_a_cut_does_not_matter_to_leaves_the_warnings_of_other_threads_alone(ball, monkeypatch):
    # Filters are those of the whole process.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with monkeypatch.context() as patched:
            patched.delattr(warnings, "catch_warnings")
            assert np.isfinite(chladni.caricature(*ball, k=3)).all()
            assert chladni.symmetry(*ball, k=3).classes.shape == (3,)


def test_results_with_arrays_can_be_compared_and_are_themselves(pebble):
    V, F = pebble
    for found in (chladni.match(V, F, V, F, method="same"), chladni.symmetry(V, F, k=4)):
        assert found == found and found != copy.deepcopy(found)
        assert found in {found}


def test_warnings_name_the_line_of_the_call():
    # Three vertices in two places each: less harmonics than are asked for.
    V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0], [0, 0, 1]]
    F = [[0, 1, 2], [3, 4, 5]]
    calls = [
        lambda: chladni.Basis(V, F, 6),
        lambda: chladni.symmetry(V, F, k=6),
        lambda: chladni.caricature(V, F, k=6),
    ]
    for call in calls:
        with pytest.warns(chladni.ChladniWarning, match="4 harmonics instead of 6") as caught:
            call()
        assert [Path(warning.filename).name for warning in caught] == [Path(__file__).name]


def test_meshes_come_back_from_their_files(tmp_path, pebble):
    V, F = pebble
    for name in ("a.obj", "a.ply"):
        chladni.write_mesh(tmp_path / name, V, F)
        again, faces = chladni.read_mesh(str(tmp_path / name))
        assert (faces == F).all() and np.allclose(again, V, rtol=0, atol=1e-7)
    with pytest.raises(chladni.FileError, match="no such|No such"):
        chladni.read_mesh(tmp_path / "missing.obj")
    with pytest.raises(FileNotFoundError) as missing:
        chladni.read_mesh(tmp_path / "missing.obj")
    assert isinstance(missing.value, chladni.FileError) and missing.value.errno == errno.ENOENT
    again = pickle.loads(pickle.dumps(missing.value))
    assert again.errno == errno.ENOENT and str(again) == str(missing.value)
    if os.name == "posix":
        # A link that leads to itself is there, and cannot be read.
        (tmp_path / "loop.obj").symlink_to("loop.obj")
        with pytest.raises(chladni.FileError) as unread:
            chladni.read_mesh(tmp_path / "loop.obj")
        assert not isinstance(unread.value, FileNotFoundError)
    # No file has a name that leads through another file.
    with pytest.raises(FileNotFoundError):
        chladni.read_mesh(tmp_path / "a.obj" / "a.obj")
    (tmp_path / "bad.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n")
    for bad in (lambda: chladni.read_mesh(tmp_path / "bad.ply"), lambda: chladni.write_mesh(tmp_path / "a.txt", V, F)):
        with pytest.raises(chladni.FileError):
            bad()
    V, F = chladni.read_mesh("sample:head")
    assert V.shape[1] == F.shape[1] == 3 and F.max() < len(V)
