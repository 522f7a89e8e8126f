"""All eigenpairs of A up to a gap without any factor: conjugate gradients with algebraic multigrid solve (A − σI) y = x,
for meshes whose factors do not fit on all ranks together. Without factors nothing counts eigenvalues (Sylvester). Instead
it is searched again, from random starts, orthogonal to all that was found, until that finds nothing below the gap."""

import os

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from ritz import rotated

TOLERANCE = 1e-11
# σ = −SHIFT K times the mean distance of eigenvalues: nearer to 0, fewer steps are needed, but each takes longer.
SHIFT = 0.08
# Vectors that are kept beside those of the pairs.
SPACE = 64
ROUNDS = 40
# Rounds of polishing, at most, and the residual ‖A x − λ x‖ / ‖λ x‖ at which they end.
POLISHES, RESIDUAL = 4, 2e-10


def constants(a, folder, zeros):
    """The eigenvectors for λ = 0: on each connected component, the square root of the mass."""
    first, end = a.getOwnershipRange()
    root_mass = np.fromfile(os.path.join(folder, "root_mass.f64"), dtype="<f8", count=end - first, offset=8 * first)
    component = np.fromfile(os.path.join(folder, "component.u32"), dtype="<u4", count=end - first, offset=4 * first)
    vectors = [a.createVecRight() for _ in range(zeros)]
    for c, vector in enumerate(vectors):
        vector.setArray(np.where(component == c, root_mass, 0.0))
        vector.normalize()
    return vectors


class Search:
    """Krylov–Schur from just below the spectrum, orthogonal to what is known."""

    def __init__(self, a, shift, known):
        self.a, self.known, self.values = a, known, np.zeros(len(known))
        self.shift, self.searches = shift, 0
        # A − σI and its multigrid are kept here: SLEPc drops its own with each search.
        self.shifted = a.duplicate(copy=True)
        self.shifted.shift(-shift)
        self.shifted.setOption(PETSc.Mat.Option.SPD, True)
        self.ksp = PETSc.KSP().create(a.comm)
        self.ksp.setType("cg")
        self.ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        self.ksp.setTolerances(rtol=TOLERANCE, max_it=10_000)
        self.ksp.setErrorIfNotConverged(True)
        self.ksp.getPC().setType("gamg")
        self.ksp.setOperators(self.shifted)
        self.inverse = PETSc.Mat().createPython(a.getSizes(), context=self, comm=a.comm)
        self.inverse.setUp()

    def mult(self, _, x, y):
        """y = (A − σI)⁻¹ x."""
        self.ksp.solve(x, y)

    def find(self, count):
        """At least the `count` lowest pairs among what is orthogonal to all known vectors, or all of these where there are
        fewer; they are known from then on. Returns their eigenvalues."""
        rest = self.a.getSize()[0] - len(self.known)
        count = min(count, rest)
        eps = SLEPc.EPS().create(self.a.comm)
        eps.setOperators(self.inverse)
        eps.setProblemType(SLEPc.EPS.ProblemType.HEP)
        eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_REAL)
        eps.setDimensions(count, min(count + SPACE, rest), min(SPACE, rest))
        eps.setTolerances(TOLERANCE, 1000)
        eps.setDeflationSpace(self.known)
        # Another start each time: what is missing may have been orthogonal to the one before.
        start, rows = self.a.createVecRight(), self.a.getOwnershipRange()
        start.setArray(np.random.default_rng([self.searches, rows[0]]).standard_normal(rows[1] - rows[0]))
        eps.setInitialSpace([start])
        eps.setFromOptions()
        eps.solve()
        found = eps.getConverged()
        if found < count:
            raise RuntimeError(f"{found} of {count} harmonics converged")
        values = []
        for i in range(found):
            vector = self.a.createVecRight()
            values.append(1 / eps.getEigenpair(i, vector).real + self.shift)
            self.known.append(vector)
        self.searches += 1
        eps.destroy()
        self.values = np.append(self.values, values)
        return np.array(values)

    def polish(self, order):
        """The known vectors in this order as columns, each after a step of inverse iteration, then after a Rayleigh–Ritz
        projection of all; repeated until their residuals are small."""
        start, image, m = self.a.createVecRight(), self.a.createVecRight(), len(order)
        bv = SLEPc.BV().create(self.a.comm)
        bv.setSizes((start.getLocalSize(), self.a.getSize()[0]), m)
        bv.setFromOptions()
        for j, i in enumerate(order):
            bv.insertVec(j, self.known[i])
            self.known[i].destroy()
        for _ in range(POLISHES):
            for j in range(m):
                bv.copyVec(j, start)
                column = bv.getColumn(j)
                self.ksp.solve(start, column)
                bv.restoreColumn(j, column)
            bv.orthogonalize()
            projected = np.empty((m, m))
            for j in range(m):
                bv.copyVec(j, start)
                self.a.mult(start, image)
                projected[j] = bv.dotVec(image)
            values = rotated(bv, projected)
            worst = 0.0
            for j, value in enumerate(values):
                bv.copyVec(j, start)
                self.a.mult(start, image)
                image.axpy(-value, start)
                worst = max(worst, image.norm() / abs(value))
            if worst < RESIDUAL:
                break
        return values, bv


def last_gap(values, wanted, gap):
    """How many of the ascending values lie below the last gap; None if all beyond the wanted ones are one group."""
    ends = [j for j in range(wanted, len(values)) if values[j] - values[j - 1] > gap * values[j]]
    return ends[-1] if ends else None


def pairs(a, settings, stages, write):
    """Finds the pairs, hands them to `write`, and returns what the report says of them."""
    zeros, wanted, gap = settings["zeros"], settings["harmonics"], settings["gap"]
    stages.begin("solve", "harmonics")
    search = Search(a, -SHIFT * wanted * settings["weyl"], constants(a, settings["folder"], zeros))
    search.find(wanted - zeros + 2)
    for _ in range(ROUNDS):
        order = np.argsort(search.values, kind="stable")
        end = last_gap(search.values[order], wanted, gap)
        if end is None:
            search.find(8)
            continue
        stages.begin("count", "searching again")
        if search.find(1).min() > search.values[order[end]] * (1 - 0.5 * gap):
            break
    else:
        raise RuntimeError("each search found harmonics that those before it had missed")
    stages.begin("polish", "polishing")
    values, bv = search.polish(order[zeros:end])
    write(bv, len(values))
    return {"eigenvalues": list(map(float, values)), "counts": [], "searches": search.searches}
