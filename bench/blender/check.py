"""usage: check.py DANCE.glb  (in a Python that has bpy and numpy)

Opens a dance in Blender without a window, plays it, and compares the vertices that Blender shows with those that the
file means: the rest positions plus the sum of targets times weights, read here without Blender.
"""

import json
import struct
import sys

import bpy
import numpy as np

path = sys.argv[1]
data = open(path, "rb").read()
json_bytes = struct.unpack_from("<I", data, 12)[0]
root = json.loads(data[20 : 20 + json_bytes])
binary = data[28 + json_bytes :]


def accessor(index):
    entry = root["accessors"][index]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[entry["type"]]
    start = root["bufferViews"][entry["bufferView"]].get("byteOffset", 0)
    kind = {5126: np.float32, 5125: np.uint32}[entry["componentType"]]
    return np.frombuffer(binary, kind, entry["count"] * width, start).reshape(-1, width).squeeze()


primitive = root["meshes"][0]["primitives"][0]
rest = accessor(primitive["attributes"]["POSITION"])
targets = np.array([accessor(target["POSITION"]) for target in primitive["targets"]])
sampler = root["animations"][0]["samplers"][0]
times = accessor(sampler["input"])
weights = accessor(sampler["output"]).reshape(len(times), len(targets))

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
scene = bpy.context.scene
body = next(thing for thing in scene.objects if thing.type == "MESH")
keys = body.data.shape_keys
assert len(keys.key_blocks) == len(targets) + 1, len(keys.key_blocks)
fps = scene.render.fps / scene.render.fps_base
diagonal = np.linalg.norm(rest.max(0) - rest.min(0))

worst, moved = 0.0, 0.0
for key in range(0, len(times), max(1, len(times) // 20)):
    at = times[key] * fps
    scene.frame_set(int(at), subframe=at - int(at))
    shown = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    found = np.empty(3 * len(shown.vertices), np.float32)
    shown.vertices.foreach_get("co", found)
    found = found.reshape(-1, 3)
    meant = rest + np.tensordot(weights[key], targets, 1)
    meant = np.stack([meant[:, 0], -meant[:, 2], meant[:, 1]], 1)  # Blender's z is up.
    worst = max(worst, np.abs(found - meant).max() / diagonal)
    moved = max(moved, np.abs(meant - np.stack([rest[:, 0], -rest[:, 2], rest[:, 1]], 1)).max() / diagonal)

limits = [(block.slider_min, block.slider_max) for block in keys.key_blocks]
assert weights.min() >= min(limits)[0] and weights.max() <= max(limits)[1]
print(
    f"Blender {bpy.app.version_string}: {len(targets)} shape keys, {len(times)} keys at {fps:g} frames a second; "
    f"moves by up to {100 * moved:.1f} % of the size; farthest from what the file means: {100 * worst:.4f} %"
)
assert moved > 0.01 and worst < 1e-3
