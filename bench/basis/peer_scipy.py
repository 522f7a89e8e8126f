"""SciPy: eigsh (ARPACK) on the exported operator, shift-inverted by SuperLU."""

import sys
import time

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from measure import Operator, report

operator = Operator(sys.argv[1], sys.argv[2])
k = int(sys.argv[3])
n = operator.n
s = sp.csc_matrix((operator.data, operator.indices.astype(np.int32), operator.indptr.astype(np.int32)), (n, n))
m = sp.diags(operator.mass).tocsc()
start = time.perf_counter()
# The symmetrized form is what ARPACK solves fastest: no products with M.
root = sp.diags(1 / np.sqrt(operator.mass))
a = (root @ s @ root).tocsc()
lu = sla.splu(a + 0.01 * sp.identity(n, format="csc"), permc_spec="MMD_AT_PLUS_A",
              diag_pivot_thresh=0.0, options=dict(SymmetricMode=True))
inverse = sla.LinearOperator((n, n), matvec=lu.solve)
values, vectors = sla.eigsh(a, k=k, sigma=-0.01, OPinv=inverse, tol=1e-10)
seconds = time.perf_counter() - start
report(operator, values, root @ vectors, seconds)
