from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, Literal

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Progress = Callable[[str, int, int], object]
Matrix = scipy.sparse.spmatrix | scipy.sparse.sparray | ArrayLike
Method = Literal["same", "icp", "fit", "map"]

class Error(Exception): ...
class InputError(Error, ValueError): ...
class NotCertifiedError(Error, RuntimeError): ...
class FileError(Error, OSError): ...
class InternalError(Error, RuntimeError): ...
class ChladniWarning(UserWarning): ...

class Certificate:
    @property
    def inertia_counts_match(self) -> bool | None: ...
    @property
    def max_relative_residual(self) -> float: ...
    @property
    def max_orthogonality_error(self) -> float: ...
    @property
    def is_precise(self) -> bool: ...

class Basis:
    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        k: int,
        *,
        whole_clusters: bool = False,
        threads: int | None = None,
        progress: Progress | None = None,
        engine: str = "chladni",
        ranks: int | None = None,
        groups: int | None = None,
        iterative: bool = False,
        hosts: str | PathLike[str] | None = None,
        scratch: str | PathLike[str] | None = None,
        boundary: Literal["neumann", "dirichlet"] = "neumann",
    ) -> None: ...
    @property
    def eigenvalues(self) -> Floats: ...
    @property
    def eigenvectors(self) -> Floats: ...
    @property
    def mass(self) -> Floats: ...
    @property
    def certificate(self) -> Certificate: ...

class Match:
    p2p: Indices
    triangles: Indices
    weights: Floats
    points: Floats
    targets: Floats
    confidence: Floats
    transform: Floats
    coverage: float
    flipped_triangles: int
    near_tie: bool

class Symmetry:
    classes: NDArray[np.int8]
    scores: Floats
    eigenvectors: Floats
    normal: Floats | None
    offset: float | None

class MeshHeatMethodDistanceSolver:
    def __init__(self, V: ArrayLike, F: ArrayLike, t_coef: float = 1.0, use_robust: bool = True) -> None: ...
    def compute_distance(self, v_ind: int) -> Floats: ...
    def compute_distance_multisource(self, v_inds: ArrayLike) -> Floats: ...

def compute_distance(V: ArrayLike, F: ArrayLike, v_ind: int) -> Floats: ...
def compute_distance_multisource(V: ArrayLike, F: ArrayLike, v_inds: ArrayLike) -> Floats: ...
def mesh_laplacian(
    verts: ArrayLike, faces: ArrayLike, mollify_factor: float = 1e-5
) -> tuple[scipy.sparse.csc_matrix, scipy.sparse.dia_matrix]: ...
def point_cloud_laplacian(
    points: ArrayLike, mollify_factor: float = 1e-5, n_neighbors: int = 30
) -> tuple[scipy.sparse.csc_matrix, scipy.sparse.dia_matrix]: ...
def eigsh(
    A: Matrix,
    k: int = 6,
    M: Matrix | None = None,
    sigma: float | None = None,
    which: str = "LM",
    v0: Any = None,
    ncv: Any = None,
    maxiter: Any = None,
    tol: float = 0,
    return_eigenvectors: bool = True,
    Minv: Any = None,
    OPinv: Any = None,
    mode: str = "normal",
    rng: Any = None,
    *,
    return_certificate: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Any: ...
def HKS(evals: ArrayLike, evects: ArrayLike, time_list: ArrayLike, scaled: bool = False) -> Floats: ...
def WKS(
    evals: ArrayLike, evects: ArrayLike, energy_list: ArrayLike, sigma: float, scaled: bool = False
) -> Floats: ...
def auto_HKS(evals: ArrayLike, evects: ArrayLike, num_T: int, scaled: bool = True) -> Floats: ...
def auto_WKS(evals: ArrayLike, evects: ArrayLike, num_E: int, scaled: bool = True) -> Floats: ...
def FM_to_p2p(
    FM_12: ArrayLike, evects1: ArrayLike, evects2: ArrayLike, use_adj: bool = False, n_jobs: Any = None
) -> Indices: ...
def p2p_to_FM(p2p_21: ArrayLike, evects1: ArrayLike, evects2: ArrayLike, A2: Matrix | None = None) -> Floats: ...
def zoomout_refine(
    FM_12: ArrayLike,
    evects1: ArrayLike,
    evects2: ArrayLike,
    nit: int = 10,
    step: int | tuple[int, int] = 1,
    A2: Matrix | None = None,
    subsample: tuple[ArrayLike, ArrayLike] | None = None,
    return_p2p: bool = False,
    n_jobs: Any = None,
    verbose: bool = False,
    *,
    progress: Progress | None = None,
) -> Any: ...
def match(
    V1: ArrayLike,
    F1: ArrayLike,
    V2: ArrayLike,
    F2: ArrayLike,
    landmarks: ArrayLike | None = None,
    *,
    method: Method = "fit",
    seed: int = 0,
    rigid: bool = False,
    progress: Progress | None = None,
) -> Match: ...
def caricature(
    V: ArrayLike | Basis,
    F: ArrayLike | None = None,
    *,
    template: str | int | Sequence[ArrayLike] = "ellipsoid",
    mu: float = -0.5,
    k: int = 512,
    model: Literal["coordinate", "normal", "distance"] = "coordinate",
    landmarks: ArrayLike | None = None,
    method: Method = "fit",
    seed: int = 0,
    progress: Progress | None = None,
) -> Floats: ...
def symmetry(
    V: ArrayLike | Basis, F: ArrayLike | None = None, *, k: int = 64, progress: Progress | None = None
) -> Symmetry: ...
def read_mesh(path: str | PathLike[str]) -> tuple[Floats, Indices]: ...
def write_mesh(path: str | PathLike[str], V: ArrayLike, F: ArrayLike) -> None: ...
