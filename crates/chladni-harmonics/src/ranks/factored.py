"""All eigenpairs of A up to a bound by factors of A − σI: MUMPS counts eigenvalues and solves."""

import math

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from ritz import rotated

TOLERANCE = 1e-10
ROUNDS = 40
# A bound with more than SPARE · K + FEW eigenvalues below it is lowered, in at most LOWERED rounds. It stays where a bound
# within the ratio NEAR has too few: between them lies a group of many equal eigenvalues.
SPARE, FEW = 1.25, 16
LOWERED, NEAR = 20, 1.02
# MUMPS's INFOG(1) where memory or a limit of it is too small (its manual, section "Error and warning diagnostics").
NO_MEMORY = (-7, -8, -9, -11, -12, -13, -17, -19, -20, -22)


class Counter:
    """Factors A − σI by MUMPS: L D Lᵀ over all ranks."""

    def __init__(self, a):
        self.a, self.shifted = a, a.duplicate(copy=True)
        self.pc = PETSc.PC().create(a.comm)
        self.pc.setType("cholesky")
        self.pc.setFactorSolverType("mumps")

    def factor(self, shift):
        self.a.copy(self.shifted, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self.shifted.shift(-shift)
        self.shifted.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.pc.setOperators(self.shifted)
        self.pc.setUp()
        factor = self.pc.getFactorMatrix()
        # PETSc leaves it at a flag where MUMPS fails.
        code = factor.getMumpsInfog(1)
        if code in NO_MEMORY:
            without = "--iterative (Python: iterative=True) solves without factors"
            raise MemoryError(f"the factors do not fit on these ranks; {without}")
        if code < 0:
            raise RuntimeError(f"MUMPS cannot factor A − σI: its error {code}")
        return factor

    def below(self, shift):
        """How many eigenvalues are below the shift (Sylvester)."""
        return self.factor(shift).getInertia()[0]


def interval(counter, wanted, zeros, weyl, gap):
    """(a, b) with the zeros alone below a, and at least `wanted` eigenvalues below b, but not many more, and none of them
    nearer to it than the share `gap`; and the number of eigenvalues below b."""
    low = 0.05 * weyl
    for _ in range(ROUNDS):
        if counter.below(low) == zeros:
            break
        low *= 0.2
    else:
        raise RuntimeError(f"there are not {zeros} eigenvalues at 0: no shift is just above them")
    high, room = max(1.02 * weyl * (wanted + 2 - zeros), 4 * low), 1
    # The highest shift with too few below it, the lowest with too many.
    lower, upper = low, math.inf
    for attempt in range(ROUNDS):
        count = counter.below(high)
        if count < wanted:
            lower = high
            if upper == math.inf:
                high *= min(max(1.02, (wanted + 3) / max(count, 1)), 4)
            else:
                high = math.sqrt(lower * upper) if upper > NEAR * lower else upper
        elif count > SPARE * wanted + FEW and high > NEAR * lower and attempt < LOWERED:
            upper = high
            high = max(high * (wanted + 3) / count, math.sqrt(lower * high))
        elif counter.below(high * (1 - gap)) == count:
            return low, high, count
        else:
            high *= 1 + 3 * room * gap
            room *= 2
    raise RuntimeError(f"no shift was found with {wanted} eigenvalues below it")


def spectrum(a, low, high, expected, groups):
    """SLEPc's Krylov–Schur with shift and invert, in slices between which inertia counts."""
    eps = SLEPc.EPS().create(a.comm)
    eps.setOperators(a)
    eps.setProblemType(SLEPc.EPS.ProblemType.HEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.ALL)
    eps.setInterval(low, high)
    eps.setTolerances(TOLERANCE, 200)
    eps.setDimensions(int(min(max(expected // groups, 8), 64)), PETSc.DECIDE, PETSc.DECIDE)
    if groups > 1:
        eps.setKrylovSchurPartitions(groups)
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    ksp = eps.getKrylovSchurKSP() if groups > 1 else st.getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    ksp.getPC().setFactorSolverType("mumps")
    eps.setFromOptions()
    eps.solve()
    return eps


def quiet(values, first, last):
    """The middle of the widest gap in the middle half of values[first:last]."""
    from_, to = first + (last - first) // 4, last - (last - first) // 4
    gaps = [(values[i + 1] - values[i], i) for i in range(from_, min(to, len(values) - 1))]
    return 0.5 * (values[max(gaps)[1]] + values[max(gaps)[1] + 1]) if gaps else values[first] * (1 + 1e-3)


def polished(counter, x, shift):
    """One step of inverse iteration of the columns of x, all at once, and a Rayleigh–Ritz projection: what is left of an
    error in directions far from the shift, on which the residual depends, is gone."""
    y = x.duplicate()
    counter.factor(shift).matSolve(x, y)
    bv = SLEPc.BV().createFromMat(y)
    bv.setFromOptions()
    bv.orthogonalize()
    image = bv.matMult(counter.a)
    return rotated(bv, image.dot(bv).getDenseArray()), bv


def pairs(a, settings, stages, write):
    """Finds the pairs, hands those of each slice to `write`, and returns what the report says of them."""
    zeros, groups = settings["zeros"], settings["groups"]
    stages.begin("count", "counting")
    counter = Counter(a)
    low, high, count = interval(counter, settings["harmonics"], zeros, settings["weyl"], settings["gap"])
    stages.begin("solve", "harmonics")
    eps = spectrum(a, low, high, count - zeros, groups)
    shifts, counts = eps.getKrylovSchurInertias()
    counts = sorted(zip(map(float, shifts), map(int, counts)))
    found = eps.getConverged()
    vector = a.createVecRight()
    values = np.array([eps.getEigenpair(i, vector).real for i in range(found)])
    order = np.argsort(values, kind="stable")
    values = values[order]
    stages.begin("polish", "polishing")
    first_row, end_row = a.getOwnershipRange()
    eigenvalues = []
    bounds = [int(np.searchsorted(values, shift)) for shift, _ in counts]
    bounds = sorted({0, found, *bounds})
    for first, last in zip(bounds[:-1], bounds[1:]):
        x = PETSc.Mat().createDense(((end_row - first_row, a.getSize()[0]), (None, last - first)), comm=a.comm)
        x.setUp()
        columns = x.getDenseArray()
        for j, i in enumerate(order[first:last]):
            eps.getEigenpair(int(i), vector)
            columns[:, j] = vector.getArray(readonly=True)
        del columns
        x.assemble()
        # From below the spectrum where the lowest ones are: rounding at a shift among them would be large beside them.
        shift = -0.5 * values[0] if first == 0 else quiet(values, first, last)
        exact, bv = polished(counter, x, shift)
        eigenvalues += map(float, exact)
        write(bv, last - first)
        for done in (bv, x):
            done.destroy()
    factor = counter.pc.getFactorMatrix()
    # In millions and negative where 32 bits are too few.
    entries = float(factor.getMumpsInfog(29))
    return {
        "eigenvalues": eigenvalues,
        "counts": [*counts, (high, count)],
        "factor_entries": entries * (-1e6 if entries < 0 else 1),
        "factor_flops": factor.getMumpsRinfog(3),
    }
