"""Bases by SLEPc on the ranks of MPI."""

import math
import os
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import chladni
import numpy as np
import pytest

# What a rank leaves: pairs of 642 vertices that are none, and a count.
LEAVES = """
import array, json, sys
folder, count = sys.argv[1], int(sys.argv[2])
seconds = dict.fromkeys(["read", "count", "solve", "polish"], 0)
values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
report = dict(rows=[0, 642], eigenvalues=values, counts=[[7.0, count]], peak_bytes=1, seconds=seconds)
json.dump(report, open(folder + "/rank-0.json", "w"))
array.array("d", range(6 * 642)).tofile(open(folder + "/rank-0.f64", "wb"))
"""


@pytest.fixture
def mpirun(tmp_path, monkeypatch):
    """Puts an mpirun on the PATH that does what it is given, and a Python that seems to have slepc4py."""
    if os.name != "posix":
        pytest.skip("the programs are scripts")

    def install(script):
        version = '[ "$1" = --version ] && echo "Open MPI" && exit 0'
        for name, text in (("python", ""), ("mpirun", f"{version}\n{script}\n")):
            program = tmp_path / name
            program.write_text("#!/bin/sh\n" + text)
            program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
        monkeypatch.setenv("CHLADNI_MPI_PYTHON", str(tmp_path / "python"))

    return install


def test_ranks_that_end_without_a_result_say_why(ball, mpirun):
    mpirun('echo "chladni: rank 0 on a: it broke" >&2; exit 3')
    with pytest.raises(chladni.RanksError, match="rank 0 on a: it broke"):
        chladni.Basis(*ball, 5, engine="slepc", ranks=1)


@pytest.mark.parametrize(("count", "reason"), [(9, "counts of eigenvalues"), (7, "relative residual")])
def test_a_basis_of_ranks_that_fails_its_check_is_refused(ball, mpirun, tmp_path, count, reason):
    (tmp_path / "leaves.py").write_text(LEAVES)
    mpirun(f'for folder; do :; done; exec "{sys.executable}" "{tmp_path}/leaves.py" "$folder" {count}')
    with pytest.raises(chladni.NotCertifiedError, match=reason):
        chladni.Basis(*ball, 5, engine="slepc", ranks=1)


class Counted:
    """Counts given eigenvalues, as MUMPS does by its factors."""

    def __init__(self, values):
        self.values, self.times = np.sort(values), 0

    def below(self, shift):
        self.times += 1
        return int(np.searchsorted(self.values, shift))


@pytest.mark.parametrize(
    ("values", "zeros", "wanted", "most"),
    [
        # A surface, a long tube, one eigenvalue that many parts share, and many equal tubes.
        (np.arange(2000.0), 1, 10, 29),
        (np.arange(2000.0) ** 2 * 1e-6, 1, 10, 29),
        (np.r_[0, 0.02, np.full(500, 0.3), np.arange(1.0, 500)], 1, 10, 502),
        (np.repeat(np.arange(60.0) ** 2 * 1e-3, 200), 200, 201, 400),
    ],
)
def test_the_bound_of_the_interval_has_few_more_than_k_below_it(values, zeros, wanted, most, monkeypatch):
    path = Path(__file__).parents[2] / "crates/chladni-harmonics/src/ranks/factored.py"
    if not path.exists():
        pytest.skip("only in the repository")
    for name in ("petsc4py", "slepc4py", "ritz"):
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(PETSc=None, SLEPc=None, rotated=None))
    counter = Counted(values)
    low, high, count = runpy.run_path(str(path))["interval"](counter, wanted, zeros, 1.0, 1e-6)
    assert 0 < low < high < math.inf and counter.below(low) == zeros
    assert count == counter.below(high) == counter.below(high * (1 - 1e-6))
    assert wanted <= count <= most and counter.times < 20


def test_ranks_find_what_the_own_solver_finds(ball):
    try:
        basis = chladni.Basis(*ball, 30, engine="slepc", ranks=2)
    except chladni.Error as error:
        if "install" in str(error) or "OMPI_ALLOW_RUN_AS_ROOT" in str(error):
            pytest.skip(str(error))
        raise
    own = chladni.Basis(*ball, 30)
    assert np.allclose(basis.eigenvalues, own.eigenvalues, rtol=1e-8)
    assert np.allclose(basis.mass, own.mass)
    assert basis.certificate.is_precise


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"engine": "arpack"}, "'chladni' or 'slepc'"),
        ({"ranks": 2}, "belong to engine"),
        ({"engine": "slepc", "ranks": 0}, "ranks is 0"),
        ({"engine": "slepc", "ranks": 10**9}, "1000000000 ranks"),
        ({"engine": "slepc", "ranks": 4, "groups": 3}, "3 equal groups"),
        ({"engine": "slepc", "threads": 2}, "threads belongs to"),
        ({"threads": 1025}, "1025 threads: at most 1024"),
        ({"engine": "slepc", "hosts": "/no/such/file"}, "/no/such/file"),
    ],
)
def test_what_cannot_be_is_refused(ball, arguments, message):
    with pytest.raises(chladni.InputError, match=message):
        chladni.Basis(*ball, 5, **arguments)
