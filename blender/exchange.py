"""Meshes to the program `chladni`, and its layers back: a PLY file out, a GLB file in. Needs no Blender."""

import json
import struct

import numpy as np


def write_ply(path, positions, starts, corners, mask=None):
    """Writes polygons: `positions` n×3, where each polygon's `corners` start, and a weight for each vertex, in [0, 1]."""
    totals = np.diff(np.append(starts, len(corners)))
    numbers = ["x", "y", "z"] + (["mask"] if mask is not None else [])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    header += [f"property double {name}" for name in numbers]
    header += [f"element face {len(starts)}", "property list int int vertex_indices", "end_header", ""]
    columns = [positions] if mask is None else [positions, np.asarray(mask)[:, None]]
    with open(path, "wb") as file:
        file.write("\n".join(header).encode())
        file.write(np.hstack(columns).astype("<f8").tobytes())
        file.write(np.insert(corners, starts, totals).astype("<i4").tobytes())


def read_targets(path):
    """The morph targets of a GLB file: (name, displacement of each vertex, n×3), the lowest layer first."""
    with open(path, "rb") as file:
        content = file.read()
    length = struct.unpack_from("<I", content, 12)[0]
    root = json.loads(content[20 : 20 + length])
    data = content[20 + length + 8 :]
    mesh = root["meshes"][0]
    targets = mesh["primitives"][0].get("targets", [])
    names = mesh.get("extras", {}).get("targetNames", [])
    found = []
    for target, name in zip(targets, names):
        accessor = root["accessors"][target["POSITION"]]
        view = root["bufferViews"][accessor["bufferView"]]
        values = np.frombuffer(data, "<f4", 3 * accessor["count"], view.get("byteOffset", 0))
        found.append((name, values.reshape(-1, 3)))
    return found
