"""SLEPc: Krylov–Schur with shift and invert, factored by MUMPS."""

import sys
import time

import slepc4py

slepc4py.init(["bench"])
import numpy as np  # noqa: E402
from measure import Operator, report  # noqa: E402
from petsc4py import PETSc  # noqa: E402
from slepc4py import SLEPc  # noqa: E402

operator = Operator(sys.argv[1], sys.argv[2])
k = int(sys.argv[3])
n = operator.n
start = time.perf_counter()
root = 1 / np.sqrt(operator.mass)
columns = np.repeat(np.arange(n), np.diff(operator.indptr))
data = operator.data * root[columns] * root[operator.indices]
a = PETSc.Mat().createAIJ((n, n), csr=(operator.indptr.astype(np.int32), operator.indices.astype(np.int32), data))
a.setOption(PETSc.Mat.Option.SYMMETRIC, True)
eps = SLEPc.EPS().create()
eps.setOperators(a)
eps.setProblemType(SLEPc.EPS.ProblemType.HEP)
eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
eps.setDimensions(k, PETSc.DECIDE, PETSc.DECIDE)
eps.setTarget(-0.01)
eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
eps.setTolerances(1e-10, 1000)
st = eps.getST()
st.setType(SLEPc.ST.Type.SINVERT)
ksp = st.getKSP()
ksp.setType("preonly")
pc = ksp.getPC()
pc.setType("cholesky")
pc.setFactorSolverType("mumps")
eps.solve()
found = min(eps.getConverged(), k)
values = np.empty(found)
vectors = np.empty((n, found))
x = a.createVecRight()
for i in range(found):
    values[i] = eps.getEigenpair(i, x).real
    vectors[:, i] = x.getArray()
seconds = time.perf_counter() - start
report(operator, values, vectors * root[:, None], seconds)
