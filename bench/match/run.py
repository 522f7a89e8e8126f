"""Matches the same pairs of heads with chladni and with its peers, in one run, and writes the
table between `<!-- match:begin -->` and `<!-- match:end -->` of BENCHMARKS.md.

    python bench/match/run.py --chladni target/release/chladni --data ../shared/data/meshes

Peers: trimesh's nricp_amberg, Open3D's FPFH + RANSAC + ICP and, with --pycpd (minutes), pycpd. A
peer that is not installed or fails is written as such. Every method starts from the same files; E
is also given turned and scaled, so that no method profits from the pose in the file. With --poses N,
every head and animal is then moved by N random similarities and must find itself again, through
`cargo run --example poses`; 20 make 200 poses.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np
import trimesh
from scipy.spatial import cKDTree

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from section import BENCHMARKS, machine, write_section

PAIRS = {
    "A": ("heads/igea.ply", "heads/decimated-max.obj"),
    "B": ("heads/face.obj", "heads/demosthenes-low-res.obj"),
    "C": ("heads/face.obj", "heads/target.obj"),
    "D": ("heads/reference.obj", "heads/target.obj"),
    "E": ("heads/generic_neutral_mesh.obj", "heads/identity005.obj"),
}
# Published with trimesh's own test of nricp_amberg on pair D.
LANDMARKS_D = np.array([
    (177, 1633), (181, 1561), (614, 1556), (610, 1629), (114, 315), (398, 413), (812, 412),
    (227, 99), (241, 87), (674, 86), (660, 98), (362, 574), (779, 573)])


def load(path):
    """Vertices in file order, fan-triangulated faces."""
    if path.suffix == ".ply":  # igea: one element of triangle strips, which trimesh does not read
        raw = path.read_bytes()
        head = raw.index(b"end_header\n") + 11
        n = int(re.search(rb"element vertex (\d+)", raw).group(1))
        v = np.frombuffer(raw, "<f4", 3 * n, head).reshape(-1, 3).astype(float)
        strips = np.frombuffer(raw, "<i4", -1, head + 12 * n + 4)
        f = []
        for run in np.split(strips, np.where(strips < 0)[0]):
            run = run[run >= 0]
            f += [(a, b, c) if i % 2 == 0 else (b, a, c) for i, (a, b, c) in enumerate(zip(run, run[1:], run[2:]))]
        return v, np.array(f)
    v, f = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            v.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            f += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return np.array(v), np.array(f)


def save_obj(path, v, f):
    with open(path, "w") as out:
        out.writelines("v %.17g %.17g %.17g\n" % tuple(p) for p in v)
        out.writelines("f %d %d %d\n" % tuple(t + 1) for t in f)


def diagonal(v):
    return np.linalg.norm(v.max(0) - v.min(0))


def known_error(pair, template, points):
    """Median error of template points where the truth is known, as a share of the diagonal."""
    if points is None or pair[0] not in "DE":
        return ""
    if pair[0] == "E":
        error = np.linalg.norm(points - template[0], axis=1)
    else:
        error = np.linalg.norm(points[LANDMARKS_D[:, 0]] - template[0][LANDMARKS_D[:, 1]], axis=1)
    error = error[~np.isnan(error)]
    return f"{100 * np.median(error) / diagonal(template[0]):.2f} %" if len(error) else ""


def aligned_distance(shape, template, matrix):
    """Median distance from the shape's vertices to the aligned template's, by the shape's diagonal."""
    moved = template[0] @ matrix[:3, :3].T + matrix[:3, 3]
    sample = shape[0][:: max(1, len(shape[0]) // 5000)]
    return np.median(cKDTree(moved).query(sample)[0]) / diagonal(shape[0])


def chladni(binary, method, files, folder, landmarks=None):
    out = folder / "m.npz"
    command = [binary, "--quiet", "match", *map(str, files), "--method", method, "--seed", "1", "-o", str(out), "--json"]
    if landmarks is not None:
        path = folder / "landmarks.txt"
        path.write_text("".join(f"{a} {b}\n" for a, b in landmarks))
        command += ["--landmarks", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    report = json.loads(done.stdout)
    found = np.load(out)
    return found["similarity"], found["point"], report["seconds"], f"{report['flipped_triangles']} flips"


def open3d_align(shape, template):
    import open3d as o3d
    def cloud(mesh):
        m = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(mesh[0]), o3d.utility.Vector3iVector(mesh[1]))
        d = diagonal(mesh[0])
        m.compute_vertex_normals()
        p = m.sample_points_uniformly(6000)
        p.scale(1 / d, center=(0, 0, 0))
        p = p.voxel_down_sample(0.02)
        f = o3d.pipelines.registration.compute_fpfh_feature(
            p, o3d.geometry.KDTreeSearchParamHybrid(radius=0.1, max_nn=100))
        return p, f, d
    o3d.utility.random.seed(1)
    start = time.perf_counter()
    (s, sf, sd), (t, tf, td) = cloud(shape), cloud(template)
    reg = o3d.pipelines.registration
    found = reg.registration_ransac_based_on_feature_matching(
        t, s, tf, sf, True, 0.03, reg.TransformationEstimationPointToPoint(True), 3,
        [reg.CorrespondenceCheckerBasedOnDistance(0.03)], reg.RANSACConvergenceCriteria(400000, 0.999))
    found = reg.registration_icp(t, s, 0.03, found.transformation,
                                 reg.TransformationEstimationPointToPoint(True))
    seconds = time.perf_counter() - start
    scale = np.diag([sd, sd, sd, 1]) @ found.transformation @ np.diag([1 / td, 1 / td, 1 / td, 1])
    back = (shape[0] - scale[:3, 3]) @ np.linalg.inv(scale[:3, :3]).T
    points = trimesh.proximity.closest_point(trimesh.Trimesh(*template, process=False), back)[0] \
        if len(back) < 30000 else None
    return scale, points, seconds, ""


def nricp(shape, template, landmarks):
    s, t = trimesh.Trimesh(*shape, process=False), trimesh.Trimesh(*template, process=False)
    start = time.perf_counter()
    # As in trimesh's own test: a Procrustes alignment on the landmarks, then the fit.
    matrix = trimesh.registration.procrustes(
        s.vertices[LANDMARKS_D[:, 0]], t.vertices[LANDMARKS_D[:, 1]])[0]
    s.apply_transform(matrix)
    pins = dict(source_landmarks=LANDMARKS_D[:, 0], target_positions=t.vertices[LANDMARKS_D[:, 1]]) \
        if landmarks else {}
    result = trimesh.registration.nricp_amberg(s, t, distance_threshold=0.1, **pins)
    points, distance, _ = trimesh.proximity.closest_point(t, result)
    seconds = time.perf_counter() - start
    return np.linalg.inv(matrix), points, seconds, f"stops {np.mean(distance) / diagonal(template[0]):.1e} away"


def cpd(shape, template):
    from pycpd import DeformableRegistration, RigidRegistration
    start = time.perf_counter()
    rng = np.random.default_rng(1)
    pick = lambda v: rng.choice(len(v), min(1000, len(v)), replace=False)
    i, j = pick(shape[0]), pick(template[0])
    a, b = shape[0][i] / diagonal(shape[0]), template[0][j] / diagonal(template[0])
    a, b = a - a.mean(0), b - b.mean(0)
    moved, (s, r, t) = RigidRegistration(X=b, Y=a, max_iterations=60).register()
    bent, _ = DeformableRegistration(X=b, Y=moved, max_iterations=60).register()
    seconds = time.perf_counter() - start
    nearest = template[0][j][cKDTree(b).query(bent)[1]]
    full = np.full_like(shape[0], np.nan)
    full[i] = nearest
    return None, full, seconds, "1000 points"


def poses(count):
    """Lines on how many random poses of each mesh are recovered, to 1e-5 of the diagonal."""
    if not count:
        return []
    command = ["cargo", "run", "--release", "--quiet", "-p", "chladni-match", "--example", "poses", "--", str(count)]
    done = subprocess.run(command, capture_output=True, text=True)
    print(done.stdout, done.stderr)
    if "recovered" not in done.stdout:
        raise RuntimeError(done.stderr.strip())
    return ["Each mesh moved by random similarities and matched with itself (`icp`); recovered is each vertex",
            "within 1e-5 of the diagonal; worst are the largest errors of any vertex, as shares of it.", "",
            *done.stdout.strip().splitlines()[:-1], "", done.stdout.strip().splitlines()[-1] + ".", ""]


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--chladni", required=True)
    arguments.add_argument("--data", required=True, type=pathlib.Path)
    arguments.add_argument("--out", default=BENCHMARKS, type=pathlib.Path)
    arguments.add_argument("--pairs", default="A,B,C,D,E,E turned")
    arguments.add_argument("--pycpd", action="store_true")
    arguments.add_argument("--poses", type=int, default=4)
    options = arguments.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for pair in options.pairs.split(","):
            files = [options.data / name for name in PAIRS[pair[0]]]
            shape, template = load(files[0]), load(files[1])
            if "turned" in pair:
                turn = trimesh.transformations.rotation_matrix(2.0, [1, 2, 3])[:3, :3]
                template = (template[0] @ turn.T * 17 + [50, -20, 300], template[1])
                files[1] = folder / "turned.obj"
                save_obj(files[1], *template)
            runs = {"chladni icp": lambda: chladni(options.chladni, "icp", files, folder),
                    "chladni fit": lambda: chladni(options.chladni, "fit", files, folder),
                    "Open3D FPFH + RANSAC + ICP": lambda: open3d_align(shape, template)}
            if options.pycpd and pair[0] in "DE":
                runs["pycpd rigid + deformable"] = lambda: cpd(shape, template)
            if pair == "D":
                runs["chladni fit, 13 landmarks"] = lambda: chladni(options.chladni, "fit", files, folder, LANDMARKS_D)
                runs["trimesh nricp_amberg, posed by landmarks"] = lambda: nricp(shape, template, False)
                runs["trimesh nricp_amberg, 13 landmarks"] = lambda: nricp(shape, template, True)
            for name, run in runs.items():
                try:
                    matrix, points, seconds, note = run()
                except Exception as error:  # a peer that fails is a result too
                    rows.append(f"| {pair} | {name} | failed: {str(error)[:80]} | | | |")
                    print(rows[-1], flush=True)
                    continue
                distance = "" if matrix is None else f"{100 * aligned_distance(shape, template, matrix):.2f} %"
                error = known_error(pair, template, points)
                rows.append(f"| {pair} | {name} | {seconds:.2f} | {distance} | {error} | {note} |")
                print(rows[-1], flush=True)
    section = "\n".join([
        "## Match", "",
        f"{machine()}; made by `bench/match/run.py`. Seconds, median distance after alignment, and median error where the",
        "truth is known (D: 13 published landmarks, E: equal indices), as shares of the diagonal. `A` is igea",
        "(134 345 vertices) onto Max Planck. Open3D gets 6000 samples a mesh, FPFH at 10 % of the diagonal and",
        "RANSAC with scale. nricp_amberg is posed by the 13 landmarks in both of its rows, and what it leaves",
        "to the target is written as `stops … away`; `chladni fit` without landmarks finds the pose itself, and",
        "its points lie on the target.", "",
        "| pair | method | s | distance | error | |", "|---|---|---|---|---|---|", *rows, "",
        *poses(options.poses)])
    write_section("match", section, options.out)


if __name__ == "__main__":
    main()
