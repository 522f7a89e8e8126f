"""One rank of `chladni basis --engine slepc`: all eigenpairs of A x = λ x up to a bound, A = M^-½ S M^-½.

usage: mpirun -n N python3 worker.py FOLDER       (python3 worker.py --check only looks for the libraries)

FOLDER holds `operator.petsc` (A, PETSc's binary format), `settings.json`: `harmonics` (K), `zeros` (how many eigenvalues
are 0), `weyl` (their mean distance), `gap` (eigenvalues that are nearer than this share of themselves are one group, which must
not be cut), `groups` (0: without factors), and, where there are no factors, `root_mass.f64` and
`component.u32`, a number for each row. Every rank leaves `rank-R.json` and `rank-R.f64` there: its rows of the vectors,
column after column, in the order of its eigenvalues. Rank 0 prints `stage NAME` lines.
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


class Stages:
    """Says on which stage the ranks are, and how many seconds each took."""

    def __init__(self):
        self.seconds, self.key, self.start = {}, None, 0.0

    def begin(self, key, words):
        self.end()
        PETSc.Sys.Print(f"stage {words}", flush=True)
        self.key, self.start = key, time.perf_counter()

    def end(self):
        if self.key:
            self.seconds[self.key] = self.seconds.get(self.key, 0.0) + time.perf_counter() - self.start


def solve(folder):
    settings = json.load(open(os.path.join(folder, "settings.json")))
    if settings["groups"] == 0:
        import iterated as method
    else:
        import factored as method
    rank, stages = PETSc.COMM_WORLD.getRank(), Stages()
    stages.begin("read", "reading")
    a = PETSc.Mat().create()
    a.setType("aij")
    a.load(PETSc.Viewer().createBinary(os.path.join(folder, "operator.petsc"), "r"))
    a.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    with open(os.path.join(folder, f"rank-{rank}.f64"), "wb") as file:

        def write(bv, count):
            for j in range(count):
                column = bv.getColumn(j)
                file.write(np.ascontiguousarray(column.getArray(readonly=True), dtype="<f8").tobytes())
                bv.restoreColumn(j, column)

        report = method.pairs(a, {**settings, "folder": folder}, stages, write)
    stages.end()
    report |= {
        "rows": list(a.getOwnershipRange()),
        "host": socket.gethostname(),
        "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "seconds": stages.seconds,
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
