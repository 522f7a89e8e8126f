"""Bases by SLEPc on the ranks of MPI."""

import chladni
import numpy as np
import pytest


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
