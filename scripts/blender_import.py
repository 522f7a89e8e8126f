#!/usr/bin/env python3
"""Opens what `chladni` exports in Blender's own importers and in trimesh, and compares the numbers.

    chladni project new SHAPE -o P.chladni && chladni project add-layer P.chladni …   # one or more
    PYTHON_WITH_BPY scripts/blender_import.py P.chladni [--chladni PATH] [--trimesh PYTHON]

For each layer the stack up to it is baked by `chladni caricature` into a PLY (every digit of its
coordinates): with the sliders of the layers up to it at 1, the shape that Blender evaluates must lie
on it to 1e-5 of the diagonal. OBJ, PLY and STL are imported, too. Says "skipped" and ends well where
there is no bpy.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

TOLERANCE = 1e-5
TRIMESH = """
import sys, numpy, trimesh
numpy.save(sys.argv[2], trimesh.load(sys.argv[1], force="mesh", process=False).vertices)
"""


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def vertices(path):
    """The vertices of a PLY as it was written, double precision."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    text = head.decode()
    count = int(re.search(r"element vertex (\d+)", text)[1])
    kinds = {"float": "f4", "double": "f8", "uchar": "u1", "float32": "f4", "float64": "f8"}
    block = text.split("element vertex")[1].split("element")[0]
    fields = [(name, "<" + kinds[kind]) for kind, name in re.findall(r"property (\w+) (\w+)", block)]
    if "ascii" in text:
        rows = body.decode().split("\n")[:count]
        table = np.array([row.split() for row in rows], float)
        names = [name for name, _ in fields]
        return np.stack([table[:, names.index(c)] for c in "xyz"], 1)
    table = np.frombuffer(body, np.dtype(fields), count)
    return np.stack([table[c].astype(float) for c in "xyz"], 1)


def baked(chladni, project, layers, folder):
    """The vertices of the result of the lowest so many layers, for every number of them."""
    found = []
    for count in range(1, len(layers) + 1):
        # Layers are tables at the end of the file: leave out those above.
        text = project.read_text()
        parts = text.split("[[layer]]")
        part = project.with_name(f".{project.stem}-part-{count}.chladni")
        part.write_text("[[layer]]".join(parts[: count + 1]))
        out = folder / f"part-{count}.ply"
        try:
            run(chladni, "--quiet", "caricature", "--recipe", part, "-o", out)
        finally:
            part.unlink()
        found.append(vertices(out))
    return found


def distance(a, b):
    """The largest distance of matching points, as a share of the diagonal."""
    diagonal = np.linalg.norm(b.max(0) - b.min(0))
    return float(np.linalg.norm(a - b, axis=1).max() / diagonal)


def place(points):
    """Blender's z is up; files have y up."""
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)


def imported(bpy, path, importer, **options):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    importer(filepath=str(path), **options)
    meshes = [o for o in bpy.data.objects if o.type == "MESH" and "Icosphere" not in o.name]
    assert len(meshes) == 1, f"{path.name}: {len(meshes)} meshes"
    return meshes[0]


def evaluated(bpy, thing):
    graph = bpy.context.evaluated_depsgraph_get()
    shape = thing.evaluated_get(graph)
    mesh = shape.to_mesh()
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    points = flat.reshape(-1, 3).astype(float)
    world = np.array(thing.matrix_world)
    shape.to_mesh_clear()
    return points @ world[:3, :3].T + world[:3, 3]


def report(what, worst):
    print(f"{'ok' if worst <= TOLERANCE else 'FAILED'}  {what}: {worst:.1e} of the diagonal")
    return worst <= TOLERANCE


def nearest(points, others):
    """For importers that merge or reorder vertices: how far each point lies from the other set."""
    from mathutils.kdtree import KDTree

    def one_way(queries, targets):
        tree = KDTree(len(targets))
        for index, point in enumerate(targets):
            tree.insert(point, index)
        tree.balance()
        return max(tree.find(point)[2] for point in queries)

    diagonal = np.linalg.norm(others.max(0) - others.min(0))
    return float(max(one_way(points, others), one_way(others, points)) / diagonal)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("project", type=pathlib.Path)
    options.add_argument("--chladni", default="target/release/chladni")
    options.add_argument("--trimesh", metavar="PYTHON", help="a Python that has trimesh, to try it, too")
    given = options.parse_args()
    try:
        import bpy
    except ImportError:
        print("skipped: this Python has no bpy (pip install bpy)")
        return
    layers = json.loads(run(given.chladni, "project", "show", given.project, "--json"))["layers"]
    names = [layer["name"] for layer in layers]
    good = True
    with tempfile.TemporaryDirectory() as place_of_files:
        folder = pathlib.Path(place_of_files)
        outputs = {kind: folder / f"result.{kind}" for kind in ("glb", "obj", "ply", "stl")}
        for path in outputs.values():
            run(given.chladni, "--quiet", "caricature", "--recipe", given.project, "-o", path)
        results = baked(given.chladni, given.project, layers, folder)

        thing = imported(bpy, outputs["glb"], bpy.ops.import_scene.gltf, merge_vertices=False)
        keys = thing.data.shape_keys.key_blocks
        assert [key.name for key in keys] == ["Basis", *names], [key.name for key in keys]
        print(f"ok  GLB in Blender {bpy.app.version_string}: sliders {', '.join(names)}")
        for count, result in enumerate(results):
            for index, key in enumerate(list(keys)[1:]):
                key.value = 1.0 if index <= count else 0.0
            thing.data.update_tag()
            bpy.context.view_layer.update()
            shape = evaluated(bpy, thing)
            aligned = len(shape) == len(result)
            worst = distance(shape, place(result)) if aligned else nearest(shape, place(result))
            good &= report(f"GLB, the lowest {count + 1} of the sliders at 1", worst)
        for kind, importer in (
            ("obj", bpy.ops.wm.obj_import),
            ("ply", bpy.ops.wm.ply_import),
            ("stl", bpy.ops.wm.stl_import),
        ):
            turned = {"forward_axis": "NEGATIVE_Z", "up_axis": "Y"}
            shape = evaluated(bpy, imported(bpy, outputs[kind], importer, **turned))
            good &= report(f"{kind.upper()} in Blender", nearest(shape, place(results[-1])))
        for kind in outputs if given.trimesh else ():
            # The mesh of a GLB is the original; its sliders are at rest.
            expected = bare(given, folder) if kind == "glb" else results[-1]
            points = folder / "points.npy"
            run(given.trimesh, "-c", TRIMESH, outputs[kind], points)
            good &= report(f"{kind.upper()} in trimesh", nearest(np.load(points), expected))
    sys.exit(not good)


def bare(given, folder):
    """The shape itself: the result with no layer."""
    text = given.project.read_text().split("[[layer]]")[0]
    part = given.project.with_name(f".{given.project.stem}-bare.chladni")
    part.write_text(text)
    out = folder / "bare.ply"
    try:
        run(given.chladni, "--quiet", "caricature", "--recipe", part, "-o", out)
    finally:
        part.unlink()
    return vertices(out)


if __name__ == "__main__":
    main()
