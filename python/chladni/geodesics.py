"""Distances along a surface by the heat method, as potpourri3d has them."""

from . import _chladni
from ._arguments import flag
from ._errors import InputError


class MeshHeatMethodDistanceSolver:
    """Distances along a triangle mesh, prepared once for any number of sources.

    Works on the intrinsic Delaunay triangulation of any mesh with area, so that ``use_robust`` cannot be False. ``t_coef``
    is the heat step in squared mean edge lengths, at most a million times the area. Vertices in one place are one. Vertices
    on pieces without a source are infinitely far away. Cannot be pickled or copied.
    """

    def __init__(self, V, F, t_coef=1.0, use_robust=True):
        if not flag(use_robust, "use_robust"):
            raise InputError("use_robust=False is not offered: the intrinsic Delaunay triangulation is always used")
        self._solver = _chladni.HeatGeodesics(V, F, t_coef)

    def __reduce__(self):
        raise InputError("a MeshHeatMethodDistanceSolver is neither pickled nor copied: make one where it is needed")

    def compute_distance(self, v_ind):
        """(n,) distances from the vertex ``v_ind``."""
        return self._solver.distances(v_ind)

    def compute_distance_multisource(self, v_inds):
        """(n,) distances from the nearest of the vertices ``v_inds``. One with only such vertices around it has 0, each of
        several others may have up to a few edges."""
        return self._solver.distances(v_inds)


def compute_distance(V, F, v_ind):
    """(n,) distances from one vertex."""
    return MeshHeatMethodDistanceSolver(V, F).compute_distance(v_ind)


def compute_distance_multisource(V, F, v_inds):
    """(n,) distances from the nearest of several vertices."""
    return MeshHeatMethodDistanceSolver(V, F).compute_distance_multisource(v_inds)
