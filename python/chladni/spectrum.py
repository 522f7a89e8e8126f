"""Laplacians of meshes, and the smallest eigenpairs of sparse matrices."""

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from . import _chladni
from ._arguments import flag, floats, number
from ._errors import InputError, NotCertifiedError

# The number of pairs whose residuals are measured at once.
BLOCK = 16


def mesh_laplacian(verts, faces, mollify_factor=1e-5):
    """The intrinsic Delaunay Laplacian of a mesh: signature and sign of ``robust_laplacian.mesh_laplacian``.

    Parameters
    ----------
    verts : (n, 3) array_like
        Vertices; equal ones stay apart (``Basis`` welds them).
    faces : (m, 3) array_like of int
        Triangles: any, also of surfaces with borders, without orientation, or not manifold.
    mollify_factor : float
        The share of the mean edge length, 0 to 1, by which every triangle is kept from being flat.

    Returns
    -------
    S : (n, n) scipy.sparse.csc_matrix
        Positive semidefinite, nothing off the diagonal above zero, rows that sum to zero.
    M : (n, n) scipy.sparse.csc_matrix
        The mixed Voronoi areas on the diagonal (robust_laplacian has a third of the triangles' areas). A vertex that no
        triangle uses has 1 in S and a thousandth of the least area in M, as in robust_laplacian; so has one that only a
        piece without area uses, which robust_laplacian gives an area.
    """
    return _matrices(*_chladni.mesh_laplacian(verts, faces, mollify_factor))


def point_cloud_laplacian(points, mollify_factor=1e-5, n_neighbors=30):
    """The Laplacian of points on a surface: signature and sign of ``robust_laplacian.point_cloud_laplacian``.

    Each point is joined to its Delaunay neighbors among its ``n_neighbors`` nearest, in the plane that fits these best.
    The triangles that this gives, each up to three times, have the Laplacian of ``mesh_laplacian``; S and M are a third of
    it.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface, in any order. One in the place of another has 1 in S and a thousandth of the least area
        in M.
    mollify_factor : float
        As in ``mesh_laplacian``.
    n_neighbors : int
        How many points around each are looked at, two or more; all where there are fewer.

    Returns
    -------
    S : (n, n) scipy.sparse.csc_matrix
        Positive semidefinite, nothing off the diagonal above zero, rows that sum to zero.
    M : (n, n) scipy.sparse.csc_matrix
        The mixed Voronoi areas on the diagonal.
    """
    return _matrices(*_chladni.point_cloud_laplacian(points, mollify_factor, n_neighbors))


def _matrices(starts, rows, values, mass):
    n = len(mass)
    diagonal = np.arange(n + 1)
    entries = ((values, rows, starts), (mass, diagonal[:-1], diagonal))
    return tuple(scipy.sparse.csc_matrix(entry, shape=(n, n)) for entry in entries)


def eigsh(
    A,
    k=6,
    M=None,
    sigma=None,
    which="LM",
    v0=None,
    ncv=None,
    maxiter=None,
    tol=0,
    return_eigenvectors=True,
    Minv=None,
    OPinv=None,
    mode="normal",
    rng=None,
    *,
    return_certificate=False,
    threads=None,
    progress=None,
):
    """The k smallest eigenpairs of A x = λ M x, certified: ``scipy.sparse.linalg.eigsh`` as it is called for them.

    Parameters
    ----------
    A : (n, n) sparse or dense matrix
        Symmetric and positive semidefinite, with a null space of any dimension; rows need not sum to zero.
    k : int
        1 to n; from half of n on, n must be at most 20,000.
    M : (n, n) sparse or dense matrix, optional
        Symmetric and positive definite, diagonal or not; the identity where it is left out.
    sigma, which, mode
        What asks for the smallest: ``sigma`` at or below 0 with ``which`` "LM" or "LA"; with "LM" a sigma of at most the
        mean of the first and last of the k eigenvalues, or any with k = n; or "SM" or "SA" without a sigma. Anything else
        is refused. Where sigma lies does not matter: the solver chooses its own shifts.
    tol : float
        0 for any, else the relative residual to be content with: ‖A x − λ M x‖ / ‖A x‖ of each pair with λ above 0. It is
        never the reason to stop; pairs that exceed it are refused.
    v0, ncv, maxiter, Minv, OPinv, rng
        Taken for the sake of calls that have them and not used: they steer ARPACK.
    return_eigenvectors : bool
        False returns the eigenvalues alone.
    return_certificate : bool
        Returns the `Certificate` besides.
    threads : int, optional
        All of the machine's unless given, at most 1024; the result does not depend on it.
    progress : callable, optional
        Called with (stage, done, total).

    Returns
    -------
    w : (k,) array
        Ascending; what is 0 to within rounding is 0.
    v : (n, k) array, in F order
        ``v.T @ M @ v`` is the identity.
    """
    if mode != "normal":
        raise InputError(f"mode is {mode!r}: only 'normal' is solved")
    if sigma is None:
        smallest, asked, hint = which in ("SM", "SA"), "", "write sigma=0, or which='SM'"
    else:
        sigma = number(sigma, "sigma")
        # The largest 1 / (λ - sigma) are of the smallest λ, where none is below sigma.
        smallest = which == "LM" or (which == "LA" and sigma <= 0)
        asked, hint = f" with sigma={sigma!r}", "write which='LM' with it, or leave sigma out and write which='SM'"
    if not smallest:
        raise InputError(f"which={which!r}{asked} asks for other pairs than the smallest: {hint}")
    tol = number(tol, "tol")
    return_eigenvectors = flag(return_eigenvectors, "return_eigenvectors")
    return_certificate = flag(return_certificate, "return_certificate")
    a, m = _columns(A, "A"), None if M is None else _columns(M, "M")
    w, v, certificate = _chladni.eigsh(a, m, k, threads, progress)
    if sigma is not None and len(w) < a[0] and not _are_nearest(w, sigma):
        raise InputError(f"sigma={sigma!r} lies among the eigenvalues ({w[0]:.3g} to {w[-1]:.3g}): others may be nearer")
    if tol and not (residual := _largest_residual(a, m, w, v)) <= tol:
        raise NotCertifiedError(f"the relative residual is {residual:.1e}, tol {tol:.1e}")
    result = (w, v) if return_eigenvectors else (w,)
    result += (certificate,) if return_certificate else ()
    return result if len(result) > 1 else w


def _are_nearest(w, sigma):
    """Whether no other eigenvalue can be nearer to sigma than all of the smallest ones, w."""
    return 2 * sigma <= w[0] + w[-1] or sigma <= w[0]


def _largest_residual(a, m, w, v):
    """The largest ‖A x − λ M x‖ / ‖A x‖ of the pairs with λ above 0. That of the certificate may be smaller: it is of
    A + tM, none of whose eigenvalues are small."""
    a, m = (part and _matrix(*part) for part in (a, m))
    largest = 0.0
    # A few pairs at a time: the products of all would take several times the memory of v.
    for first in range(0, len(w), BLOCK):
        some = slice(first, first + BLOCK)
        values, vectors = w[some], v[:, some]
        values, vectors = values[values > 0], vectors[:, values > 0]
        image = a @ vectors
        error = image - (vectors if m is None else m @ vectors) * values
        residuals = np.linalg.norm(error, axis=0) / np.linalg.norm(image, axis=0)
        # A NaN stays one.
        largest = np.maximum(largest, residuals.max(initial=0))
    return largest


def _matrix(n, starts, rows, values):
    """What `_columns` took apart."""
    return scipy.sparse.csc_matrix((values.astype(float), rows, starts), shape=(n, n))


def _columns(matrix, name):
    """(n, starts, rows, values) of compressed columns; values in any order."""
    if isinstance(matrix, scipy.sparse.linalg.LinearOperator):
        raise InputError(f"{name} is a LinearOperator, which can only be applied: its entries are needed to factor it")
    given = matrix if scipy.sparse.issparse(matrix) else floats(matrix, name)
    try:
        columns = scipy.sparse.csc_matrix(given) if given.ndim == 2 else None
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no matrix: {error}") from None
    if columns is None:
        raise InputError(f"{name} has {given.ndim} dimensions, where a matrix is needed")
    if columns.shape[0] != columns.shape[1]:
        raise InputError(f"{name} has the shape {columns.shape}, where a square matrix is needed")
    return columns.shape[0], columns.indptr, columns.indices, columns.data
