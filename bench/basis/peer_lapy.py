"""LaPy: its Solver's own eigs on the exported operator (the class around SciPy that users call)."""

import sys
import time

import numpy as np
import scipy.sparse as sp
from lapy import Solver
from measure import Operator, report

operator = Operator(sys.argv[1], sys.argv[2])
k = int(sys.argv[3])
n = operator.n
solver = Solver.__new__(Solver)
solver.stiffness = sp.csc_matrix(
    (operator.data, operator.indices.astype(np.int32), operator.indptr.astype(np.int32)), (n, n))
solver.mass = sp.diags(operator.mass).tocsc()
solver.use_cholmod = False
solver.sksparse = None
start = time.perf_counter()
values, vectors = solver.eigs(k=k)
seconds = time.perf_counter() - start
report(operator, values, vectors, seconds)
