"""The Rayleigh–Ritz projection, with which both ways to solve end."""

import numpy as np
from petsc4py import PETSc


def rotated(bv, projected):
    """Turns the m columns of `bv` into those that diagonalize `projected`, their m × m products with A; the values on its
    diagonal then, ascending."""
    values, mix = np.linalg.eigh(0.5 * (projected + projected.T))
    m = len(values)
    bv.multInPlace(PETSc.Mat().createDense((m, m), array=np.asfortranarray(mix), comm=PETSc.COMM_SELF), 0, m)
    return values
