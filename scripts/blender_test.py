#!/usr/bin/env python3
"""Drives the extension for Blender in a Blender without a window, and looks at exports of GLB files there.

    PYTHON_WITH_BPY scripts/blender_test.py target/chladni-blender.zip target/release/chladni
"""

import os
import pathlib
import sys
import tempfile
import types

FOLDER = tempfile.TemporaryDirectory(prefix="chladni-blender-")
# Blender's settings and extensions live here, not in the user's own folder.
os.environ["BLENDER_USER_RESOURCES"] = FOLDER.name

import bpy
import numpy as np

from blender_import import run, vertices

ZIP, CHLADNI = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
HERE = pathlib.Path(FOLDER.name)
LAYERS = ["--model", "distance", "--mu", "-2", "-k", "64"]


def check(name, is_so):
    if not is_so:
        sys.exit(f"FAILED: {name}")
    print(f"ok: {name}")


def places(data):
    found = np.empty(3 * len(data), np.float32)
    data.foreach_get("co", found)
    return found.reshape(-1, 3)


def empty():
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()


def rock():
    """A bumpy ball with a vertex group on its upper half, and triangles and quads."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=32)
    target = bpy.context.object
    for vertex in target.data.vertices:
        x, y, z = vertex.co
        vertex.co *= 1.0 + 0.25 * np.sin(3.0 * x) * y + 0.1 * np.cos(5.0 * z)
    group = target.vertex_groups.new(name="top")
    for vertex in target.data.vertices:
        if vertex.co.z > 0.2:
            group.add([vertex.index], 1.0, "REPLACE")
    return target


def the_addon_makes_shape_keys():
    try:
        bpy.ops.extensions.package_install_files(filepath=str(ZIP), repo="user_default", enable_on_install=True)
    except (AttributeError, RuntimeError) as error:
        sys.exit(f"FAILED: the zip cannot be installed: {error}")
    name = "bl_ext.user_default.chladni"
    check("the zip is installed as an extension", name in bpy.context.preferences.addons)
    preferences = bpy.context.preferences.addons[name].preferences
    preferences.program = "//chladni"
    is_absolute = preferences.program == os.path.abspath("chladni")
    check("a path from the folder of the file is made absolute", is_absolute)
    target, settings = rock(), bpy.context.scene.chladni
    preferences.program = "chladni"
    check("a path that is not absolute is called so", "not absolute" in refused())
    preferences.program = str(CHLADNI)
    rest = places(target.data.vertices)
    settings.template, settings.model, settings.mu, settings.harmonics = "ellipsoid", "distance", -2.0, 64
    check("it runs", bpy.ops.object.chladni_caricature() == {"FINISHED"})
    keys = target.data.shape_keys.key_blocks
    check("there is a basis and a shape key at 1", [k.name for k in keys] == ["Basis", "Caricature"] and keys[1].value == 1)
    check("the mesh itself is as it was", np.array_equal(places(keys[0].data), rest))
    import importlib

    package = importlib.import_module(name)
    shape, result = HERE / "shape.ply", HERE / "result.ply"
    package.exchange.write_ply(shape, *package.polygons(target.data))
    run(CHLADNI, "caricature", shape, "ellipsoid", *LAYERS, "-o", result)
    far = np.abs(places(keys[1].data) - vertices(result)).max()
    check(f"it is what the command makes ({far:.1e})", far < 1e-5)
    whole = np.abs(places(keys[1].data) - rest).max(1)

    settings.mask, settings.name = "top", "Only the top"
    check("it runs on a vertex group", bpy.ops.object.chladni_caricature() == {"FINISHED"})
    part = np.abs(places(keys["Only the top"].data) - rest).max(1)
    top = np.array([len(vertex.groups) > 0 for vertex in target.data.vertices])
    low = rest[:, 2] < -0.6
    check(
        f"the group moves and what is far from it does not ({part[top].mean():.3f}, {part[low].max():.3f})",
        part[top].mean() > 0.3 * whole[top].mean() and part[low].max() < 0.1 * whole[low].max(),
    )
    settings.mask, settings.mu, settings.name = "", -4.0, "Caricature"
    bpy.ops.object.chladni_caricature()
    check("again renews the key of the same name", [k.name for k in keys] == ["Basis", "Caricature", "Only the top"])
    again = np.abs(places(keys["Caricature"].data) - rest).max(1)
    check("and it is another one", again.mean() > 1.3 * whole.mean())

    project = HERE / "two.chladni"
    run(CHLADNI, "project", "new", shape, "-o", project, "-k", "64")
    for layer, mu in [("broad", "-1"), ("narrow", "-0.5")]:
        run(CHLADNI, "project", "add-layer", project, "--template", "sphere", "--mu", mu, "--name", layer)
    settings.template, settings.project, settings.name = "project", str(project), "Two"
    check("a project runs", bpy.ops.object.chladni_caricature() == {"FINISHED"})
    check("each layer is a key", {"Two: broad", "Two: narrow"} <= {key.name for key in keys})
    run(CHLADNI, "caricature", "--recipe", project, "-o", result)
    both = places(keys["Two: broad"].data) + places(keys["Two: narrow"].data) - rest
    check("together they are the result", np.abs(both - vertices(result)).max() < 1e-5)

    before = places(keys["Two: broad"].data)
    run(CHLADNI, "project", "add-layer", project, "--template", "ellipsoid", "--mu", "-0.3", "--name", "broad")
    check("a project with two layers of one name runs", bpy.ops.object.chladni_caricature() == {"FINISHED"})
    check("each has a key of its own", {"Two: broad", "Two: narrow", "Two: broad 2"} <= {key.name for key in keys})
    check("and the first is what it was", np.abs(places(keys["Two: broad"].data) - before).max() < 1e-5)

    project = HERE / "grows.chladni"
    run(CHLADNI, "project", "new", shape, "-o", project, "-k", "64")
    run(CHLADNI, "project", "add-layer", project, "--template", "sphere", "--name", "first")
    settings.project, settings.name = str(project), "A name that is longer than the names that Blender keeps for keys"
    bpy.ops.object.chladni_caricature()
    alone, count = keys[-1], len(keys)
    bpy.ops.object.chladni_caricature()
    check("a key whose name was shortened is renewed", len(keys) == count and alone.value == 1)
    alone = alone.name
    run(CHLADNI, "project", "add-layer", project, "--template", "ellipsoid", "--name", "second")
    bpy.ops.object.chladni_caricature()
    check("keys of both layers are new", len(keys) == count + 2 and [key.value for key in keys][-2:] == [1, 1])
    check("and that of the one layer does not add to them", keys[alone].value == 0)

    settings.project, settings.template, settings.name = "", "ellipsoid", "Muted"
    bpy.ops.object.chladni_caricature()
    muted = keys["Muted"]
    muted.mute, muted.vertex_group, muted.relative_key = True, "top", keys["Only the top"]
    muted.slider_min, muted.slider_max, muted.value = 0.0, 0.25, 0.25
    bpy.ops.object.chladni_caricature()
    alone = keys["Muted"]
    free = not alone.mute and alone.vertex_group == "" and alone.relative_key == target.data.shape_keys.reference_key
    check("a renewed key acts on the whole basis again", free and alone.value == 1 and alone.slider_max >= 1)

    settings.mask, settings.template = "nowhere", "ellipsoid"
    check("a group that is not there is an error in words", "no vertex group" in refused())
    settings.mask, settings.template, settings.project = "", "project", ""
    check("a project that is not chosen is one, too", "choose the project" in refused())

    settings.template, settings.name = "ellipsoid", "Seen"
    target.active_shape_key_index, target.show_only_shape_key = 0, True
    bpy.ops.object.chladni_caricature()
    check("a key that was pinned hides no new one", not target.show_only_shape_key)
    count, target.data.shape_keys.use_relative = len(keys), False
    check("absolute keys are an error in words", "are absolute" in refused() and len(keys) == count)
    target.data.shape_keys.use_relative = True
    for name, scale, uneven in [("mirrored", (1.0, -1.0, 1.0), False), ("stretched", (1.0, 1.0, 2.0), True)]:
        target.scale = scale
        work = package.Work(target, settings, str(CHLADNI))
        work.end()
        check(f"a {name} object is scaled {'un' * uneven}evenly", work.is_uneven == uneven)
    target.scale = 1.0, 1.0, 1.0
    process = types.SimpleNamespace(poll=lambda: None)
    running = types.SimpleNamespace(work=types.SimpleNamespace(process=process))
    let_go = types.SimpleNamespace(type="ESC", value="RELEASE")
    passed = package.ChladniCaricature.modal(running, bpy.context, let_go)
    check("an Escape that is let go stops nothing", passed == {"PASS_THROUGH"})
    linked_meshes_are_refused(target)

    settings.template, settings.name = "ellipsoid", "Afterwards"
    work = package.Work(target, settings, str(CHLADNI))
    work.process.wait()
    kept = [type(value) for value in vars(work).values()]
    check("nothing is kept that undo would replace", not any(issubclass(kind, bpy.types.ID) for kind in kept))
    target.name = "Renamed"
    work.take()
    check("an object is found again under another name", "Afterwards" in [key.name for key in keys])
    bpy.data.objects.remove(target)
    try:
        ended = work.take()
    except ValueError as error:
        ended = str(error)
    work.end()
    check("one that is gone is an error in words", "deleted in the meantime" in ended)


def linked_meshes_are_refused(target):
    library = HERE / "library.blend"
    there = target.data.copy()
    there.name = "There"
    bpy.data.libraries.write(str(library), {there})
    bpy.data.meshes.remove(there)
    with bpy.data.libraries.load(str(library), link=True) as (_, linked):
        linked.meshes = ["There"]
    other = bpy.data.objects.new("Linked", linked.meshes[0])
    bpy.context.collection.objects.link(other)
    bpy.context.view_layer.objects.active = other
    check("a mesh that is linked is refused", "make it local" in refused())
    bpy.context.view_layer.objects.active = target
    bpy.data.objects.remove(other)


def refused():
    """Why the operator does not run."""
    try:
        return str(bpy.ops.object.chladni_caricature())
    except RuntimeError as error:
        return str(error)


def everything_of_a_glb_survives():
    empty()
    body = rock()
    body.name = "Body"
    body.vertex_groups.clear()
    bones = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", bones)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, low, high in [("lower", -1.0, 0.0), ("upper", 0.0, 1.0)]:
        bone = bones.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, low), (0, 0, high)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name in ["lower", "upper"]:
        group = body.vertex_groups.new(name=name)
        for vertex in body.data.vertices:
            up = min(max(0.5 + vertex.co.z, 0.0), 1.0)
            group.add([vertex.index], up if name == "upper" else 1.0 - up, "REPLACE")
    body.parent = rig
    body.modifiers.new("Rig", "ARMATURE").object = rig
    for pose, frame in [(0.0, 1), (0.6, 20)]:
        bone = rig.pose.bones["upper"]
        bone.rotation_mode = "XYZ"
        bone.rotation_euler[0] = pose
        bone.keyframe_insert("rotation_euler", frame=frame)
    body.shape_key_add(name="Basis", from_mix=False)
    smile = body.shape_key_add(name="Smile", from_mix=False)
    for i, point in enumerate(smile.data):
        point.co.y += 0.2 * max(point.co.x, 0.0)
    for weight, frame in [(0.0, 1), (1.0, 20)]:
        smile.value = weight
        smile.keyframe_insert("value", frame=frame)
    smile.value = 0.0
    # Normals of a person's own: all turned to one side a little.
    normals = [(v.normal + type(v.normal)((0.5, 0.0, 0.0))).normalized() for v in body.data.vertices]
    body.data.normals_split_custom_set_from_vertices(normals)
    material = bpy.data.materials.new("Skin")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.3125
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 0.75
    body.data.materials.append(material)
    bpy.ops.object.camera_add(location=(1, -5, 2))
    before, after = HERE / "before.glb", HERE / "after.glb"
    bpy.ops.export_scene.gltf(filepath=str(before), export_cameras=True)
    run(CHLADNI, "caricature", before, "ellipsoid", *LAYERS, "-o", after)

    first, second = scene_of(before), scene_of(after)
    check(f"shape keys: {first['keys']} and the new one", second["keys"] == first["keys"] + ["caricature"])
    for name in ["bones", "groups", "materials", "cameras", "actions"]:
        check(f"{name}: {first[name]}", first[name] and first[name] == second[name])
    for name in ["places", "weights", "normals", "smile", "moved"]:
        check(f"{name} are the same, bit for bit", np.array_equal(first[name], second[name]))
    apart = np.abs(first["normals"] - first["flat"]).max()
    check(f"the custom normals are custom ({apart:.2f})", apart > 0.2)
    check("the new key moves the shape", np.abs(second["new"] - second["places"]).max() > 0.02)


def scene_of(path):
    """What Blender makes of a GLB file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path))
    body = next(o for o in bpy.data.objects if o.type == "MESH" and o.data.shape_keys)
    mesh, keys = body.data, body.data.shape_keys.key_blocks
    groups = [group.name for group in body.vertex_groups]
    weight = np.zeros((len(mesh.vertices), len(groups)))
    for vertex in mesh.vertices:
        for element in vertex.groups:
            weight[vertex.index, element.group] = element.weight
    corner_normals = np.empty(3 * len(mesh.loops), np.float32)
    mesh.corner_normals.foreach_get("vector", corner_normals)
    flat = np.array([polygon.normal for polygon in mesh.polygons for _ in polygon.loop_indices], np.float32)
    nodes = [(m.name, m.node_tree.nodes["Principled BSDF"]) for m in mesh.materials]
    principled = [
        (name, *(round(node.inputs[i].default_value, 6) for i in ("Roughness", "Metallic"))) for name, node in nodes
    ]
    actions = sorted((action.name, tuple(action.frame_range)) for action in bpy.data.actions)
    found = {
        "keys": [key.name for key in keys],
        "bones": sorted(bone.name for armature in bpy.data.armatures for bone in armature.bones),
        "groups": groups,
        "materials": principled,
        "cameras": sorted((o.name, round(o.data.angle, 5)) for o in bpy.data.objects if o.type == "CAMERA"),
        "actions": actions,
        "places": places(keys[0].data),
        "weights": weight,
        "normals": corner_normals.reshape(-1, 3),
        "flat": flat,
        "smile": places(keys["Smile"].data),
        "new": places(keys[-1].data),
    }
    # The animation still plays: bone and slider, half way.
    bpy.context.scene.frame_set(12)
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    found["moved"] = places(evaluated.to_mesh().vertices).copy()
    evaluated.to_mesh_clear()
    return found


bpy.ops.wm.read_factory_settings(use_empty=True)
the_addon_makes_shape_keys()
everything_of_a_glb_survives()
print("Blender", bpy.app.version_string, "agrees", flush=True)
# As a module, 4.2 crashes while Python takes it down.
FOLDER.cleanup()
os._exit(0)
