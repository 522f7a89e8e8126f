"""The natural vibrations of triangle meshes: certified eigenpairs, signatures, functional maps, geodesics, caricatures.

Rows of every array are the vertices that were given, in their order; units are theirs. Long work gives up the
interpreter's lock; what takes ``progress`` stops at Ctrl-C and calls ``progress(stage, done, total)``.
"""

from importlib.metadata import version as _version

from ._chladni import Certificate, StoredBasis
from ._errors import (
    ChladniWarning,
    Error,
    FileError,
    InputError,
    InternalError,
    MissingFileError,
    NotCertifiedError,
    RanksError,
)
from .functional_maps import FM_to_p2p, icp_refine, p2p_to_FM, zoomout_refine
from .geodesics import MeshHeatMethodDistanceSolver, compute_distance, compute_distance_multisource
from .shapes import Basis, Match, Symmetry, caricature, match, read_mesh, symmetry, write_mesh
from .signatures import HKS, WKS, auto_HKS, auto_WKS
from .spectrum import eigsh, mesh_laplacian, point_cloud_laplacian

__version__ = _version("chladni")

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
