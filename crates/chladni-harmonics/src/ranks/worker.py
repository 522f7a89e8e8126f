"""One rank of `chladni basis --engine slepc`: all eigenpairs of A x = λ x up to a bound, A = M^-½ S M^-½.

usage: mpirun -n N python3 worker.py FOLDER       (python3 worker.py --check only looks for the libraries)

FOLDER holds `operator.petsc` (A, PETSc's binary format) and `settings.json`: `harmonics` (K), `zeros` (how many eigenvalues
are 0), `weyl` (their mean distance), `groups`. Every rank leaves `rank-R.json` and `rank-R.f64` there: its rows of the
vectors, column after column, in the order of its eigenvalues. Rank 0 prints `stage NAME` lines.
"""

import glob
import json
import os
import resource
import socket
import sys
import time
from importlib.machinery import EXTENSION_SUFFIXES

# Debian's modules are found through links that only its development packages make.
for library in ("petsc", "slepc"):
    sys.path += sorted(glob.glob(f"/usr/lib/{library}dir/*/*-real/lib/python3/dist-packages"))[-1:]

import slepc4py  # noqa: E402

if sys.argv[1:] == ["--check"]:
    import numpy  # noqa: F401
    import petsc4py  # noqa: F401

    # The module of another Python can be found, but not loaded; to load it would start MPI.
    built = [glob.glob(f"{slepc4py.__path__[0]}/lib/**/SLEPc{end}", recursive=True) for end in EXTENSION_SUFFIXES]
    sys.exit(0 if any(built) else 1)

# MUMPS counts negative pivots of all ranks only where the last front is not ScaLAPACK's (13) and zero pivots are found (24).
MUMPS = {"mat_mumps_icntl_13": "1", "mat_mumps_icntl_24": "1"}
OPTIONS = [text for name, value in MUMPS.items() for at in ("", "st_") for text in (f"-{at}{name}", value)]
slepc4py.init([sys.argv[0], *OPTIONS])

import numpy as np  # noqa: E402
from petsc4py import PETSc  # noqa: E402
from slepc4py import SLEPc  # noqa: E402

TOLERANCE = 1e-10
# Eigenvalues that are this much nearer than their own size count as one group, which no bound may cut.
ROOM = 1e-6
ROUNDS = 40


def stage(name):
    PETSc.Sys.Print(f"stage {name}", flush=True)


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
        return self.pc.getFactorMatrix()

    def below(self, shift):
        """How many eigenvalues are below the shift (Sylvester)."""
        return self.factor(shift).getInertia()[0]


def interval(counter, wanted, zeros, weyl):
    """(a, b) with the zeros alone below a, and at least `wanted` eigenvalues below b, none of them just below it."""
    low = 0.05 * weyl
    for _ in range(ROUNDS):
        if counter.below(low) == zeros:
            break
        low *= 0.2
    else:
        raise RuntimeError(f"there are not {zeros} eigenvalues at 0: no shift is just above them")
    high, room = max(1.02 * weyl * (wanted + 2 - zeros), 4 * low), 1
    for _ in range(ROUNDS):
        count = counter.below(high)
        if count < wanted:
            high *= min(max(1.02, (wanted + 3) / max(count, 1)), 4)
        elif counter.below(high * (1 - ROOM)) == count:
            return low, high, count
        else:
            high *= 1 + 3 * room * ROOM
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
    projected = image.dot(bv).getDenseArray()
    values, mix = np.linalg.eigh(0.5 * (projected + projected.T))
    m = len(values)
    bv.multInPlace(PETSc.Mat().createDense((m, m), array=np.asfortranarray(mix), comm=PETSc.COMM_SELF), 0, m)
    return values, bv


def write_columns(file, bv, count):
    for j in range(count):
        column = bv.getColumn(j)
        file.write(np.ascontiguousarray(column.getArray(readonly=True), dtype="<f8").tobytes())
        bv.restoreColumn(j, column)


def solve(folder):
    settings = json.load(open(os.path.join(folder, "settings.json")))
    zeros, groups = settings["zeros"], settings["groups"]
    rank, start, seconds = PETSc.COMM_WORLD.getRank(), time.perf_counter(), {}
    stage("reading")
    a = PETSc.Mat().create()
    a.setType("aij")
    a.load(PETSc.Viewer().createBinary(os.path.join(folder, "operator.petsc"), "r"))
    a.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    seconds["read"] = time.perf_counter() - start
    stage("counting")
    counter = Counter(a)
    low, high, count = interval(counter, settings["harmonics"], zeros, settings["weyl"])
    seconds["count"] = time.perf_counter() - start - sum(seconds.values())
    stage("harmonics")
    eps = spectrum(a, low, high, count - zeros, groups)
    shifts, counts = eps.getKrylovSchurInertias()
    counts = sorted(zip(map(float, shifts), map(int, counts)))
    found = eps.getConverged()
    vector = a.createVecRight()
    values = np.array([eps.getEigenpair(i, vector).real for i in range(found)])
    order = np.argsort(values, kind="stable")
    values = values[order]
    seconds["solve"] = time.perf_counter() - start - sum(seconds.values())
    stage("polishing")
    eigenvalues = []
    first_row, end_row = a.getOwnershipRange()
    with open(os.path.join(folder, f"rank-{rank}.f64"), "wb") as file:
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
            write_columns(file, bv, last - first)
            for done in (bv, x):
                done.destroy()
    seconds["polish"] = time.perf_counter() - start - sum(seconds.values())
    factor = counter.pc.getFactorMatrix()
    # In millions and negative where 32 bits are too few.
    entries = float(factor.getMumpsInfog(29))
    report = {
        "rows": [first_row, end_row],
        "eigenvalues": eigenvalues,
        "counts": counts,
        "below": [high, count],
        "host": socket.gethostname(),
        "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "factor_entries": entries * (-1e6 if entries < 0 else 1),
        "factor_flops": factor.getMumpsRinfog(3),
        "seconds": seconds,
    }
    # Renamed when it is whole.
    path = os.path.join(folder, f"rank-{rank}.json")
    with open(path + ".part", "w") as file:
        json.dump(report, file)
    os.replace(path + ".part", path)


try:
    solve(sys.argv[1])
except Exception as error:  # noqa: BLE001
    reason = " ".join(str(error).split())
    print(f"chladni: rank {PETSc.COMM_WORLD.getRank()} on {socket.gethostname()}: {reason}", file=sys.stderr, flush=True)
    # The others may wait for this one: leave without the farewell that would wait for them, and mpirun ends them.
    os._exit(3)
