from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal, SupportsIndex, final

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

__version__: str
__all__ = [
    "HKS",
    "WKS",
    "Basis",
    "Certificate",
    "ChladniWarning",
    "Error",
    "FM_to_p2p",
    "FileError",
    "InputError",
    "InternalError",
    "Match",
    "MeshHeatMethodDistanceSolver",
    "MissingFileError",
    "NotCertifiedError",
    "RanksError",
    "StoredBasis",
    "Symmetry",
    "auto_HKS",
    "auto_WKS",
    "caricature",
    "compute_distance",
    "compute_distance_multisource",
    "eigsh",
    "icp_refine",
    "match",
    "mesh_laplacian",
    "p2p_to_FM",
    "point_cloud_laplacian",
    "read_mesh",
    "symmetry",
    "write_mesh",
    "zoomout_refine",
]

_Floats = NDArray[np.float64]
_Indices = NDArray[np.int64]
_Progress = Callable[[str, int, int], object]
_Matrix = scipy.sparse.spmatrix | scipy.sparse.sparray | ArrayLike
_Method = Literal["same", "icp", "fit", "map"]

class Error(Exception): ...
class InputError(Error, ValueError): ...
class NotCertifiedError(Error, RuntimeError): ...
class RanksError(Error, RuntimeError): ...
class FileError(Error, OSError): ...
class InternalError(Error, RuntimeError): ...
class MissingFileError(FileError, FileNotFoundError): ...
class ChladniWarning(UserWarning): ...

@final
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
    def __new__(
        cls,
        V: ArrayLike,
        F: ArrayLike,
        k: SupportsIndex,
        *,
        whole_clusters: bool = False,
        threads: SupportsIndex | None = None,
        progress: _Progress | None = None,
        engine: str = "chladni",
        ranks: SupportsIndex | None = None,
        groups: SupportsIndex | None = None,
        iterative: bool = False,
        hosts: str | PathLike[str] | None = None,
        scratch: str | PathLike[str] | None = None,
        boundary: Literal["neumann", "dirichlet"] = "neumann",
    ) -> Self: ...
    @property
    def eigenvalues(self) -> _Floats: ...
    @property
    def eigenvectors(self) -> _Floats: ...
    @property
    def mass(self) -> _Floats: ...
    @property
    def certificate(self) -> Certificate: ...

@final
class StoredBasis:
    def __new__(cls, folder: str | PathLike[str]) -> Self: ...
    @property
    def eigenvalues(self) -> _Floats: ...
    @property
    def mass(self) -> _Floats: ...
    def analyze(self, signal: ArrayLike, *, progress: _Progress | None = None) -> _Floats: ...
    def synthesize(self, coefficients: ArrayLike, *, progress: _Progress | None = None) -> _Floats: ...

@dataclass(frozen=True, eq=False)
class Match:
    p2p: _Indices
    triangles: _Indices
    weights: _Floats
    points: _Floats
    targets: _Floats
    confidence: _Floats
    transform: _Floats
    coverage: float
    residual_median: float | None
    residual_p95: float | None
    flipped_triangles: int
    strongly_stretched: int
    near_tie: bool

@dataclass(frozen=True, eq=False)
class Symmetry:
    classes: NDArray[np.int8]
    scores: _Floats
    eigenvectors: _Floats
    normal: _Floats | None
    offset: float | None

class MeshHeatMethodDistanceSolver:
    def __init__(self, V: ArrayLike, F: ArrayLike, t_coef: float = 1.0, use_robust: bool = True) -> None: ...
    def compute_distance(self, v_ind: SupportsIndex) -> _Floats: ...
    def compute_distance_multisource(self, v_inds: ArrayLike) -> _Floats: ...

def compute_distance(V: ArrayLike, F: ArrayLike, v_ind: SupportsIndex) -> _Floats: ...
def compute_distance_multisource(V: ArrayLike, F: ArrayLike, v_inds: ArrayLike) -> _Floats: ...
def mesh_laplacian(
    verts: ArrayLike, faces: ArrayLike, mollify_factor: float = 1e-5
) -> tuple[scipy.sparse.csc_matrix, scipy.sparse.csc_matrix]: ...
def point_cloud_laplacian(
    points: ArrayLike, mollify_factor: float = 1e-5, n_neighbors: SupportsIndex = 30
) -> tuple[scipy.sparse.csc_matrix, scipy.sparse.csc_matrix]: ...
def eigsh(
    A: _Matrix,
    k: SupportsIndex = 6,
    M: _Matrix | None = None,
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
    threads: SupportsIndex | None = None,
    progress: _Progress | None = None,
) -> Any: ...
def HKS(evals: ArrayLike, evects: ArrayLike, time_list: ArrayLike, scaled: bool = False) -> _Floats: ...
def WKS(
    evals: ArrayLike, evects: ArrayLike, energy_list: ArrayLike, sigma: float, scaled: bool = False
) -> _Floats: ...
def auto_HKS(
    evals: ArrayLike, evects: ArrayLike, num_T: SupportsIndex, landmarks: ArrayLike | None = None, scaled: bool = True
) -> _Floats: ...
def auto_WKS(
    evals: ArrayLike, evects: ArrayLike, num_E: SupportsIndex, landmarks: ArrayLike | None = None, scaled: bool = True
) -> _Floats: ...
def FM_to_p2p(
    FM_12: ArrayLike, evects1: ArrayLike, evects2: ArrayLike, use_adj: bool = False, n_jobs: Any = None
) -> _Indices: ...
def p2p_to_FM(p2p_21: ArrayLike, evects1: ArrayLike, evects2: ArrayLike, A2: _Matrix | None = None) -> _Floats: ...
def zoomout_refine(
    FM_12: ArrayLike,
    evects1: ArrayLike,
    evects2: ArrayLike,
    nit: SupportsIndex = 10,
    step: SupportsIndex | tuple[SupportsIndex, SupportsIndex] = 1,
    A2: _Matrix | None = None,
    subsample: tuple[ArrayLike, ArrayLike] | None = None,
    return_p2p: bool = False,
    n_jobs: Any = None,
    verbose: bool = False,
    *,
    progress: _Progress | None = None,
) -> Any: ...
def icp_refine(
    FM_12: ArrayLike,
    evects1: ArrayLike,
    evects2: ArrayLike,
    nit: SupportsIndex | None = 10,
    tol: float = 1e-10,
    use_adj: bool = False,
    return_p2p: bool = False,
    n_jobs: Any = None,
    verbose: bool = False,
    *,
    A2: _Matrix | None = None,
) -> Any: ...
def match(
    V1: ArrayLike,
    F1: ArrayLike,
    V2: ArrayLike,
    F2: ArrayLike,
    landmarks: ArrayLike | None = None,
    *,
    method: _Method = "fit",
    seed: SupportsIndex = 0,
    rigid: bool = False,
    progress: _Progress | None = None,
) -> Match: ...
def caricature(
    V: ArrayLike | Basis,
    F: ArrayLike | None = None,
    *,
    template: Literal["ellipsoid", "sphere"] | SupportsIndex | Sequence[ArrayLike] = "ellipsoid",
    mu: float = -0.5,
    k: SupportsIndex = 512,
    model: Literal["coordinate", "normal", "distance"] = "coordinate",
    landmarks: ArrayLike | None = None,
    method: _Method = "fit",
    seed: SupportsIndex = 0,
    progress: _Progress | None = None,
) -> _Floats: ...
def symmetry(
    V: ArrayLike | Basis, F: ArrayLike | None = None, *, k: SupportsIndex = 64, progress: _Progress | None = None
) -> Symmetry: ...
def read_mesh(path: str | PathLike[str]) -> tuple[_Floats, _Indices]: ...
def write_mesh(path: str | PathLike[str], V: ArrayLike, F: ArrayLike) -> None: ...
