"""Bases in folders, read in pieces."""

import copy
import errno
import os
import pickle

import chladni
import numpy as np
import pytest


def stored(folder, V, F, k):
    """A folder as `chladni basis -o folder/` writes it, of a mesh without vertices in one place, and the basis in it."""
    basis = chladni.Basis(V, F, k)
    arrays = {"eigenvalues": basis.eigenvalues, "mass": basis.mass, "eigenvectors": basis.eigenvectors}
    for name, values in (arrays | {"operator_vertex": np.arange(len(V))}).items():
        np.save(folder / f"{name}.npy", values)
    return basis


def test_signals_are_taken_apart_and_put_together(tmp_path, pebble):
    basis = stored(tmp_path, *pebble, 20)
    read = chladni.StoredBasis(tmp_path)
    assert np.array_equal(read.eigenvalues, basis.eigenvalues) and np.array_equal(read.mass, basis.mass)
    assert "642 vertices, 20 harmonics" in repr(read)
    V, h = pebble[0], basis.eigenvectors
    coefficients = read.analyze(V)
    assert coefficients.shape == (20, 3)
    assert np.allclose(coefficients, h.T @ (basis.mass[:, None] * V))
    assert np.allclose(read.analyze(V[:, 1]), coefficients[:, 1])
    assert np.allclose(read.synthesize(coefficients), h @ coefficients)
    assert np.allclose(read.synthesize([0, 0, 2.5]), 2.5 * h[:, 2])
    assert np.array_equal(read.synthesize(np.zeros((0, 2))), np.zeros((642, 2)))
    assert read.analyze(V[:, :0]).shape == (20, 0)


def test_a_folder_is_found_from_another_one_and_after_pickling(tmp_path, ball, monkeypatch):
    stored(tmp_path, *ball, 5)
    monkeypatch.chdir(tmp_path.parent)
    read = chladni.StoredBasis(tmp_path.name)
    expected = read.analyze(ball[0])
    monkeypatch.chdir("/")
    for same in (read, pickle.loads(pickle.dumps(read)), copy.copy(read), copy.deepcopy(read)):
        assert type(same) is chladni.StoredBasis and np.array_equal(same.analyze(ball[0]), expected)


def test_what_does_not_fit_is_refused(tmp_path, ball):
    with pytest.raises(chladni.MissingFileError, match="eigenvectors") as raised:
        chladni.StoredBasis(tmp_path / "nowhere")
    assert isinstance(raised.value, FileNotFoundError) and raised.value.errno == errno.ENOENT
    if os.name == "posix":
        # A link that leads to itself is there, and cannot be read.
        (tmp_path / "loop").symlink_to("loop")
        with pytest.raises(chladni.FileError) as raised:
            chladni.StoredBasis(tmp_path / "loop")
        assert not isinstance(raised.value, FileNotFoundError)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(chladni.MissingFileError):
        chladni.StoredBasis(tmp_path / "file" / "nowhere")
    stored(tmp_path, *ball, 5)
    read = chladni.StoredBasis(tmp_path)
    with pytest.raises(chladni.InputError, match="3 vertices, where the basis has 642"):
        read.analyze([1, 2, 3])
    with pytest.raises(chladni.InputError, match="6 coefficients, where the basis has 5"):
        read.synthesize(np.ones(6))
    with pytest.raises(chladni.InputError, match="NaN in row 1"):
        read.synthesize([1, np.nan])
    with pytest.raises(chladni.InputError, match="real numbers"):
        read.analyze(np.array(["a", "b"]))
    np.save(tmp_path / "mass.npy", np.ones(641))
    with pytest.raises(chladni.FileError, match="641"):
        chladni.StoredBasis(tmp_path)
    np.save(tmp_path / "eigenvectors.npy", np.ones((642, 5)))
    with pytest.raises(chladni.FileError, match="column by column"):
        chladni.StoredBasis(tmp_path)
