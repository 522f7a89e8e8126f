"""Beside the libraries whose calls are taken over; each test is skipped where its library is not installed."""

import chladni
import numpy as np
import pytest
import scipy.sparse.linalg


def test_the_laplacian_is_that_of_robust_laplacian(sphere, square, pebble):
    peer = pytest.importorskip("robust_laplacian")
    for V, F in (sphere, square, pebble):
        S, M = chladni.mesh_laplacian(V, F)
        L, areas = peer.mesh_laplacian(V, F)
        assert abs(S - L).max() < 1e-10
        assert areas.sum() == pytest.approx(M.sum())
        ours = chladni.eigsh(L, 20, areas, sigma=-0.01)[0]
        theirs = np.sort(scipy.sparse.linalg.eigsh(L, 20, areas, sigma=-0.01)[0])
        assert np.allclose(ours, theirs, rtol=1e-8, atol=1e-9)


def test_flat_triangles_and_unused_vertices_are_those_of_robust_laplacian(square):
    peer = pytest.importorskip("robust_laplacian")
    V, F = square
    # A border, triangles without height at it, and vertices that none uses.
    V = np.vstack([V, 0.5 * (V[:10] + V[1:11]), [[9, 9, 9], [8, 8, 8]]])
    F = np.vstack([F, np.stack([np.arange(10), np.arange(10) + len(V) - 12, np.arange(1, 11)], axis=1)])
    (S, M), (L, areas) = chladni.mesh_laplacian(V, F), peer.mesh_laplacian(V, F)
    assert abs(S - L).max() < 1e-9 * abs(L).max()
    assert (S.diagonal()[-2:] == L.diagonal()[-2:]).all()
    for mass in (M, areas):
        assert np.allclose(mass.diagonal()[-2:], 1e-3 * mass.diagonal()[:-2].min())
    assert (chladni.eigsh(S, 9, M, sigma=-0.01)[0][1:] > 0).all()


def test_the_laplacian_of_points_is_that_of_robust_laplacian(sphere, pebble):
    peer = pytest.importorskip("robust_laplacian")
    for V in (sphere[0], pebble[0]):
        S, M = chladni.point_cloud_laplacian(V)
        L, areas = peer.point_cloud_laplacian(V)
        # Neighbors are chosen by another rule where four of them lie nearly on one circle.
        assert M.sum() == pytest.approx(areas.sum(), rel=1e-3)
        ours = chladni.eigsh(S, 20, areas, sigma=-0.01)[0]
        theirs = np.sort(scipy.sparse.linalg.eigsh(L, 20, areas, sigma=-0.01)[0])
        assert np.allclose(ours, theirs, rtol=1e-3, atol=1e-8)
        # Their matrices are solved, too.
        ours = chladni.eigsh(L, 20, areas, sigma=1e-8)[0]
        assert np.allclose(ours, theirs, rtol=1e-7, atol=1e-8)


def test_distances_are_those_of_potpourri3d(sphere, pebble):
    peer = pytest.importorskip("potpourri3d")
    for V, F in (sphere, pebble):
        ours, theirs = (lib.MeshHeatMethodDistanceSolver(V, F, 2.0) for lib in (chladni, peer))
        for source in (0, 100):
            a, b = ours.compute_distance(source), theirs.compute_distance(source)
            assert np.abs(a - b).max() < 0.01 * b.max()
        a, b = (solver.compute_distance_multisource([3, 99, 200]) for solver in (ours, theirs))
        assert np.abs(a - b).max() < 0.02 * b.max()


@pytest.fixture
def lapy_with_ours(monkeypatch):
    peer = pytest.importorskip("lapy")
    import lapy.solver

    def swap():
        monkeypatch.setattr(lapy.solver, "_eigsh", chladni.eigsh)

    return peer, swap


def test_lapy_has_its_own_spectra_of_triangles_and_tetrahedra(lapy_with_ours, pebble):
    lapy, swap = lapy_with_ours
    steps = np.arange(6)
    P = np.stack([x.ravel() for x in np.meshgrid(steps, steps * 1.1, steps * 0.9, indexing="ij")], axis=1)
    two, five = [0, 1], range(5)
    corners = [(a, b, c) for a in two for b in two for c in two]
    first = [(i, j, k) for i in five for j in five for k in five]
    cubes = [[((i + a) * 6 + j + b) * 6 + k + c for a, b, c in corners] for i, j, k in first]
    T = [(c[0], c[a], c[b], c[7]) for c in cubes for a, b in ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1))]
    tetrahedra = lapy.TetMesh(P, np.array(T))
    tetrahedra.orient_()
    triangles = lapy.TriaMesh(*pebble)
    solvers = [lapy.Solver(shape, lump=lump) for shape in (triangles, tetrahedra) for lump in (False, True)]
    theirs = [solver.eigs(k=30) for solver in solvers]
    swap()
    for solver, (w, v) in zip(solvers, theirs, strict=True):
        ours, vectors = solver.eigs(k=30)
        assert np.allclose(ours, w, rtol=1e-7, atol=1e-8)
        overlap = np.abs(vectors.T @ (solver.mass @ v))
        apart = np.diff(w, prepend=-1, append=w[-1] + 1e-9)
        alone = (apart[:-1] > 1e-3) & (apart[1:] > 1e-3)
        assert np.allclose(np.diag(overlap)[alone], 1, atol=1e-6)


def test_lapy_has_its_own_heat_and_shape_dna(lapy_with_ours, pebble):
    lapy, swap = lapy_with_ours
    import lapy.diffgeo
    import lapy.heat
    import lapy.shapedna

    mesh = lapy.TriaMesh(*pebble)

    def results():
        w, v = lapy.Solver(mesh).eigs(k=30)
        heat = lapy.heat.diagonal(np.array([[0.5, 1.0]]), np.arange(10), v, w[:, None], 30)
        dna = lapy.shapedna.compute_shapedna(mesh, k=20)
        return heat, dna["Eigenvalues"]

    theirs = results()
    swap()
    for a, b in zip(results(), theirs, strict=True):
        assert np.allclose(a, b, rtol=1e-6, atol=1e-6)
    # No spectrum, but the same distances.
    distances = lapy.diffgeo.compute_geodesic_f(mesh, lapy.heat.diffusion(mesh, [0], m=1.0))
    ours = chladni.compute_distance(*pebble, 0)
    assert np.corrcoef(distances, ours)[0, 1] > 0.99


def test_pyfm_has_its_own_signatures_maps_and_zoomout(pebble, monkeypatch):
    pytest.importorskip("pyFM")
    import pyFM.mesh
    import pyFM.refine
    import pyFM.signatures
    import pyFM.spectral

    V, F = pebble
    order = np.random.default_rng(4).permutation(len(V))
    inverse = np.argsort(order)

    def processed(V, F):
        mesh = pyFM.mesh.TriMesh(V, F)
        mesh.process(k=40, intrinsic=False, verbose=False)
        return mesh

    theirs = processed(V, F)
    monkeypatch.setattr(scipy.sparse.linalg, "eigsh", chladni.eigsh)
    one, two = processed(V, F), processed(V[order], inverse[F])
    assert np.allclose(one.eigenvalues, theirs.eigenvalues, rtol=1e-8, atol=1e-8)
    for name in ("HKS", "WKS"):
        mine = getattr(pyFM.signatures, f"mesh_{name}")(one, 20)
        assert np.allclose(mine, getattr(pyFM.signatures, f"mesh_{name}")(theirs, 20), rtol=1e-5, atol=1e-8)
        auto = getattr(chladni, f"auto_{name}")(one.eigenvalues, one.eigenvectors, 20)
        assert np.allclose(auto, mine, rtol=1e-9)
        led = getattr(pyFM.signatures, f"mesh_{name}")(one, 20, landmarks=[5, 300])
        auto = getattr(chladni, f"auto_{name}")(one.eigenvalues, one.eigenvectors, 20, [5, 300])
        assert np.allclose(auto, led, rtol=1e-9, atol=1e-12)
    # ZoomOut from four functions: theirs, on our basis, and ours.
    start = pyFM.spectral.p2p_to_FM(order, one.eigenvectors[:, :4], two.eigenvectors[:, :4], A2=two.A)
    arguments = (start, one.eigenvectors, two.eigenvectors)
    options = dict(nit=12, step=3, A2=two.A, return_p2p=True)
    fm, p2p = pyFM.refine.zoomout_refine(*arguments, **options)
    ours, our_p2p = chladni.zoomout_refine(*arguments, **options)
    assert (p2p == order).all() and (our_p2p == order).all()
    assert np.allclose(fm, ours, atol=1e-9)
    some = (fm[:20, :30], *arguments[1:])
    assert np.allclose(chladni.icp_refine(*some, nit=3), pyFM.refine.icp_refine(*some, nit=3), atol=1e-9)
    assert np.allclose(chladni.p2p_to_FM(p2p, *arguments[1:]), pyFM.spectral.p2p_to_FM(p2p, *arguments[1:]), atol=1e-9)


def test_pyfm_fits_its_own_map(pebble, monkeypatch):
    pytest.importorskip("pyFM")
    import pyFM.functional
    import pyFM.mesh

    V, F = pebble
    order = np.random.default_rng(4).permutation(len(V))

    def fitted():
        meshes = [pyFM.mesh.TriMesh(V, F), pyFM.mesh.TriMesh(V[order], np.argsort(order)[F])]
        model = pyFM.functional.FunctionalMapping(*meshes)
        model.preprocess(n_descr=30, k_process=40, k_descr=40, descr_type="WKS")
        model.fit(K=(20, 20))
        return model

    theirs = fitted()
    monkeypatch.setattr(scipy.sparse.linalg, "eigsh", chladni.eigsh)
    ours = fitted()
    assert (theirs.get_p2p() == order).mean() > 0.9
    assert (ours.get_p2p() == theirs.get_p2p()).mean() > 0.95
    # The same map up to the signs of harmonics.
    meshes = [(ours.mesh1, theirs.mesh1), (ours.mesh2, theirs.mesh2)]
    one, two = [np.sign((a.eigenvectors * (a.A @ b.eigenvectors)).sum(axis=0))[:20] for a, b in meshes]
    difference = two[:, None] * ours.FM_12 * one - theirs.FM_12
    assert np.abs(difference).max() < 0.02


def test_lapy_has_its_own_poisson_and_conformal_map(lapy_with_ours, pebble, square):
    lapy, swap = lapy_with_ours
    import lapy.conformal

    def results():
        flat = lapy.Solver(lapy.TriaMesh(*square), lump=True)
        held = np.flatnonzero((np.abs(square[0][:, :2] - 0.5) > 0.499).any(axis=1))
        bump = flat.poisson(1.0, dtup=(held, np.zeros(len(held))))
        return bump, lapy.conformal.spherical_conformal_map(lapy.TriaMesh(*pebble))

    theirs = results()
    swap()
    # They need no spectrum.
    for a, b in zip(results(), theirs, strict=True):
        assert np.array_equal(a, b)
    # What the square bends by in its middle, from its series.
    odd = np.arange(1, 60, 2)
    i, j = np.meshgrid(odd, odd)
    exact = (16 * np.sin(i * np.pi / 2) * np.sin(j * np.pi / 2) / (np.pi**4 * i * j * (i * i + j * j))).sum()
    assert theirs[0].max() == pytest.approx(exact, rel=0.01)


def test_neuromodes_has_its_own_modes(lapy_with_ours, pebble):
    lapy, swap = lapy_with_ours
    eigen = pytest.importorskip("neuromodes.eigen")
    mesh = lapy.TriaMesh(*pebble)
    stiffer = 1 + 0.5 * pebble[0][:, 2]
    kinds = [dict(lump=lump, hetero=hetero) for lump in (False, True) for hetero in (None, stiffer)]

    def modes():
        solved = [eigen.EigenSolver(mesh).solve(20, **kind) for kind in kinds]
        masked = eigen.EigenSolver(mesh, mask=pebble[0][:, 0] < 0.8).solve(20)
        return [*solved, masked]

    theirs = modes()
    swap()
    for ours, peer in zip(modes(), theirs, strict=True):
        assert np.allclose(ours.evals, peer.evals, rtol=1e-7, atol=1e-8)
        overlap = np.abs((ours.emodes * (peer.mass @ peer.emodes)).sum(axis=0))
        assert np.allclose(overlap, 1, atol=1e-6)
