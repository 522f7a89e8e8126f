"""Bases of meshes, and what is made with them: matches, caricatures, symmetry classes."""

import os
from dataclasses import dataclass

import numpy as np

from . import _chladni
from ._arguments import count
from ._errors import FileError, InputError, MissingFileError


class Basis(_chladni.Basis):
    """The first k harmonics of a mesh, certified.

    ``Basis(V, F, k, *, whole_clusters=False, threads=None, progress=None)`` takes vertices (n, 3) and triangles (m, 3) of
    any mesh with area. Vertices in one place are welded: they have equal rows and share their area. With
    ``whole_clusters``, a k that would cut a multiple eigenvalue is raised to the end of its group; without, that is a
    `ChladniWarning`.

    ``threads`` are all of the machine's unless given, at most 1024; the result does not depend on them.

    With ``engine="slepc"``, SLEPc solves on so many ``ranks`` of MPI, in ``groups`` that each have a factor, on the machines
    of a file of ``hosts`` that share the folder ``scratch``; the certificate is still measured here (docs/scale.md).

    Borders are free (``boundary="neumann"``) or held: with ``boundary="dirichlet"`` harmonics are zero along them. Held ones
    can be used in all that takes eigenvalues and eigenvectors, not in ``caricature`` and ``symmetry``.

    ``eigenvectors.T @ (mass[:, None] * eigenvectors)`` is the identity. A basis can be pickled and copied.
    """

    __slots__ = ()

    def __new__(
        cls,
        V,
        F,
        k,
        *,
        whole_clusters=False,
        threads=None,
        progress=None,
        engine="chladni",
        ranks=None,
        groups=None,
        iterative=False,
        hosts=None,
        scratch=None,
        boundary="neumann",
    ):
        on_ranks = (engine, ranks, groups, iterative, hosts, scratch)
        return super().__new__(cls, V, F, k, whole_clusters, threads, progress, *on_ranks, boundary, None, False)

    def __reduce__(self):
        # A subclass may have attributes of its own.
        own = getattr(self, "__dict__", None) or None
        return _basis_of, (type(self), *self.parts()), own


def _basis_of(kind, V, F, solved):
    """What `Basis.__reduce__` took apart."""
    return _chladni.Basis.__new__(kind, V, F, 1, False, None, None, "", None, None, False, None, None, "", solved, True)


def _certificate(*parts):
    """What `Certificate.__reduce__` took apart."""
    return _chladni.restored_certificate(parts)


@dataclass(frozen=True, eq=False)
class Match:
    """For each vertex of shape 1 a point of shape 2."""

    p2p: np.ndarray
    """(n1,) the corner of that triangle with the largest weight: what pyFM calls p2p_12."""
    triangles: np.ndarray
    """(n1,) the triangle of shape 2 that the point lies in."""
    weights: np.ndarray
    """(n1, 3) its barycentric weights there."""
    points: np.ndarray
    """(n1, 3) the point, in the coordinates of shape 2."""
    targets: np.ndarray
    """(n1, 3) the point, in the coordinates of shape 1: ``transform`` applied."""
    confidence: np.ndarray
    """(n1,) how far to trust it, in [0, 1]."""
    transform: np.ndarray
    """(4, 4) the similarity from shape 2 to shape 1; it acts on columns (x, y, z, 1)."""
    coverage: float
    """Share of the area of shape 1 that is trusted."""
    residual_median: float | None
    """Median distance that is left between shape 1, bent or aligned, and shape 2; a share of the diagonal of shape 1. None
    for "map" and "same"."""
    residual_p95: float | None
    """The remaining distance that 5 % of the vertices exceed."""
    flipped_triangles: int
    """Triangles of shape 1 that are turned over on shape 2."""
    strongly_stretched: int
    """Triangles of shape 1 that are stretched more than five times as much in one direction as in the other."""
    near_tie: bool
    """Whether a different pose fits nearly as well."""


def match(V1, F1, V2, F2, landmarks=None, *, method="fit", seed=0, rigid=False, progress=None):
    """Which point of shape 2 belongs to each vertex of shape 1.

    ``landmarks`` are (m, 2) vertices of shape 1 and shape 2 that belong together. ``method`` is "fit" (shape 1 is bent
    onto shape 2), "icp" (closest points after a similarity), "map" (through a sphere, led by three or more landmarks) or
    "same" (vertex i to vertex i). ``rigid`` keeps the size of shape 2. What is doubtful is a `ChladniWarning`.
    """
    return Match(**_chladni.match_meshes(V1, F1, V2, F2, landmarks, method, seed, rigid, progress))


def caricature(
    V,
    F=None,
    *,
    template="ellipsoid",
    mu=-0.5,
    k=512,
    model="coordinate",
    landmarks=None,
    method="fit",
    seed=0,
    progress=None,
):
    """Vertices (n, 3) of the shape with its difference from ``template`` exaggerated (``mu`` < 0) or reduced (``mu`` > 0).

    ``caricature(basis, ...)`` uses the harmonics of a `Basis`, ``caricature(V, F, ...)`` solves for k of them (at most n).
    The template is "ellipsoid" or "sphere" (fitted), a mesh ``(V2, F2)``, which is matched as `match` does it, or a whole
    number K of at most k: the shape's own first K harmonics. ``model`` is "coordinate", "normal" or "distance", the
    three of the paper. Where a matched mesh is exaggerated, the finest detail is left as it is, since no match is exact
    there.
    """
    basis = _basis(V, F, k, progress)
    template = tuple(template) if isinstance(template, list) and len(template) == 2 else template
    return _chladni.caricature(basis, template, mu, model, landmarks, method, seed, progress)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """What the mirror plane of a shape does to its harmonics."""

    classes: np.ndarray
    """(k,) 1 symmetric, -1 antisymmetric, 0 neither."""
    scores: np.ndarray
    """(k,) the scalar product of each harmonic with its mirror image, in [-1, 1]."""
    eigenvectors: np.ndarray
    """(n, k) the harmonics that the classes are of: those of one eigenvalue mixed so that they have a class."""
    normal: "np.ndarray | None"
    """(3,) unit normal of the plane {p: normal · p = offset}; None where there is none and the classes are rough."""
    offset: "float | None"


def symmetry(V, F=None, *, k=64, progress=None):
    """The symmetry classes of the harmonics of a `Basis`, or of ``V, F`` with k of them (at most n)."""
    return Symmetry(**_chladni.symmetry(_basis(V, F, k, progress), progress))


def read_mesh(path):
    """Vertices (n, 3) and triangles (m, 3) of a file: OBJ, PLY, STL, OFF, GLB, glTF, Medit (.mesh); polygons are divided
    into triangles. "sample:NAME" is a shape of our own: head, template, octopus, plate, disc, drum, bell, ring, jellyfish,
    human, cat, or portrait, a head with sliders ("sample:portrait?jaw=0.5")."""
    try:
        return _chladni.read_mesh(path)
    except FileError as error:
        name = os.fsdecode(path)
        if name.startswith("sample:") or not _is_missing(name):
            raise
        raise MissingFileError(str(error)) from None


def _is_missing(name):
    """Whether no file has this name; one in a folder that may not be entered may be there."""
    try:
        os.stat(name)
    except (OSError, ValueError) as error:
        return isinstance(error, (FileNotFoundError, NotADirectoryError))
    return False


def write_mesh(path, V, F):
    """Writes a mesh, whole or not at all, in the format of the name: .obj, .ply, .stl or .glb.

    OBJ and PLY keep coordinates as they are; STL and GLB can hold 32-bit numbers only. Far from the origin, a GLB keeps
    the form of the mesh, and an STL rounds it, without a warning. Both refuse shapes of less than 1e-30 units. No format
    turns the shape: viewers of a GLB take y for up.
    """
    _chladni.write_mesh(path, V, F)


def _basis(V, F, k, progress):
    if isinstance(V, Basis):
        if F is not None:
            raise InputError("a Basis has its own triangles: leave F out")
        return V
    if F is None:
        raise InputError("give a Basis, or both V and F")
    k = count(k, "k")
    try:
        n = len(V)
    except TypeError:
        # No array of vertices: the basis says why.
        n = k
    k, on_ranks = min(k, max(n, 1)), ("chladni", None, None, False, None, None)
    # A caricature hardly depends on which of the last equal harmonics it has, so that a cut is nothing to warn of.
    return _chladni.Basis.__new__(Basis, V, F, k, False, None, progress, *on_ranks, "neumann", None, True)
