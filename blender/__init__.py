"""Sends a mesh to the program `chladni` and takes its layers back as shape keys."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile

import bpy
import numpy as np

from . import exchange

TEMPLATES = [
    ("ellipsoid", "Ellipsoid", "What makes the shape differ from the ellipsoid that fits it best"),
    ("sphere", "Sphere", "What makes it differ from a sphere"),
    ("self", "Its own detail", "What makes it differ from itself without its details"),
    ("object", "Another mesh", "What makes it differ from another mesh, such as a mean face"),
    ("project", "A project", "The layers of a project of Chladni; painted regions are carried over"),
]
MODELS = [
    ("coordinate", "Coordinate", "Moves every point along its difference: sharp features"),
    ("normal", "Normal", "Inflates and deflates along the surface: smooth parts"),
    ("distance", "Distance", "One filter for all directions: subtle, μ down to −8"),
]


# The property of a mesh that holds, for each name of a result, the shape keys that its layers became.
MADE = "chladni_keys"


def absolute(preferences, _context):
    """Makes a path from the folder of the open file absolute: elsewhere it would name another program."""
    if preferences.program.startswith("//"):
        preferences.program = os.path.abspath(bpy.path.abspath(preferences.program))


class ChladniPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program",
        subtype="FILE_PATH",
        description="The absolute path of the program chladni; empty: it is found on the PATH",
        update=absolute,
    )

    def draw(self, _context):
        self.layout.prop(self, "program")
        if not program(self):
            self.layout.label(text=f"{why_missing(self)}: give its absolute path", icon="ERROR")


class ChladniSettings(bpy.types.PropertyGroup):
    template: bpy.props.EnumProperty(name="Against", items=TEMPLATES)
    other: bpy.props.PointerProperty(
        name="Mesh", type=bpy.types.Object, poll=lambda _self, other: other.type == "MESH"
    )
    project: bpy.props.StringProperty(name="Project", subtype="FILE_PATH")
    model: bpy.props.EnumProperty(name="Model", items=MODELS)
    mu: bpy.props.FloatProperty(
        name="μ", default=-1.0, soft_min=-3.0, soft_max=1.0, description="Below 0 exaggerates, 1 is the template"
    )
    harmonics: bpy.props.IntProperty(name="Harmonics", default=256, min=1, soft_max=1024)
    mask: bpy.props.StringProperty(name="Mask", description="The vertex group that the layer is confined to")
    keep_triangles: bpy.props.BoolProperty(
        name="Keep triangles", description="Hold back what would fold the surface or pass it through itself"
    )
    name: bpy.props.StringProperty(name="Shape key", default="Caricature")


def program(preferences):
    """The program's absolute path, or None."""
    chosen = preferences.program
    if chosen:
        return chosen if os.path.isabs(chosen) and not chosen.startswith("//") else None
    # On Windows, shutil.which by itself looks first in the working folder, which may be that of a file from anywhere.
    name = "chladni.exe" if os.name == "nt" else "chladni"
    places = (os.path.join(folder, name) for folder in os.get_exec_path() if os.path.isabs(folder))
    return next(filter(shutil.which, places), None)


def why_missing(preferences):
    """Why there is no path of the program."""
    return "The path of chladni is not absolute" if preferences.program else "No program chladni on the PATH"


def polygons(mesh):
    """Positions at rest, and where each polygon's corners start, and the corners."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    rest = mesh.shape_keys.reference_key.data if mesh.shape_keys else mesh.vertices
    rest.foreach_get("co", positions)
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return positions.reshape(-1, 3), starts, corners


def weights(target, name):
    """The weight of each vertex in the vertex group called `name`."""
    group = target.vertex_groups.get(name)
    if group is None:
        raise ValueError(f"{target.name} has no vertex group “{name}”")
    found = np.zeros(len(target.data.vertices))
    for vertex in target.data.vertices:
        for element in vertex.groups:
            if element.group == group.index:
                found[vertex.index] = min(max(element.weight, 0.0), 1.0)
    return found


def check_keys(target):
    """Refuses absolute shape keys: those are shown one after the other, whatever their values are."""
    keys = target.data.shape_keys
    if keys is not None and not keys.use_relative:
        raise ValueError("the shape keys are absolute: switch Relative on, and exaggerate again")


def distinct(names):
    """The same names, with a number behind those that were there before."""
    found = []
    for name in names:
        number, own = 1, name
        while own in found or (number > 1 and own in names):
            number += 1
            own = f"{name} {number}"
        found.append(own)
    return found


class Work:
    """One run of the program on one object."""

    def __init__(self, target, settings, path):
        check_keys(target)
        scale = [abs(each) for each in target.scale]
        self.is_uneven = max(scale) > 1.001 * min(scale)
        # Undo replaces the Python object that stands for it.
        self.uid = target.session_uid
        self.name = settings.name
        self.vertices = len(target.data.vertices)
        self.folder = tempfile.TemporaryDirectory(prefix="chladni-")
        folder = pathlib.Path(self.folder.name)
        self.result, self.said = folder / "result.glb", folder / "said.txt"
        # A project has masks of its own.
        masked = settings.mask and settings.template != "project"
        mask = weights(target, settings.mask) if masked else None
        shape = folder / "shape.ply"
        exchange.write_ply(shape, *polygons(target.data), mask)
        words = [path, "--quiet", "caricature", shape]
        if settings.template == "project":
            if not settings.project:
                raise ValueError("choose the project")
            words += ["--recipe", bpy.path.abspath(settings.project)]
        else:
            words += [self.template(settings, folder), f"--mu={settings.mu}", "--model", settings.model]
            words += ["-k", settings.harmonics]
            if mask is not None:
                words += ["--mask", shape]
        if settings.keep_triangles:
            words.append("--keep-triangles")
        words += ["-o", self.result]
        with open(self.said, "w", encoding="utf-8") as said:
            self.process = subprocess.Popen([str(word) for word in words], stdout=said, stderr=said)

    @staticmethod
    def template(settings, folder):
        if settings.template == "self":
            return f"self:lowpass={min(20, settings.harmonics)}"
        if settings.template != "object":
            return settings.template
        if settings.other is None:
            raise ValueError("choose the other mesh")
        exchange.write_ply(folder / "template.ply", *polygons(settings.other.data))
        return folder / "template.ply"

    def take(self):
        """Makes a shape key of each layer, or renews those that are there, and returns what the program said."""
        said = self.said.read_text(encoding="utf-8", errors="replace").strip()
        if self.process.returncode:
            raise ValueError(said.splitlines()[-1] if said else "chladni ended without a word")
        target = next((each for each in bpy.data.objects if each.session_uid == self.uid), None)
        if target is None:
            raise ValueError("the object was deleted in the meantime")
        if target.mode == "EDIT":
            # Leaving it would write the mesh that is edited over the shape keys.
            raise ValueError("leave edit mode, and exaggerate again")
        if len(target.data.vertices) != self.vertices:
            raise ValueError("the mesh was changed in the meantime")
        check_keys(target)
        layers = exchange.read_targets(self.result)
        if target.data.shape_keys is None:
            target.shape_key_add(name="Basis", from_mix=False)
        rest = polygons(target.data)[0]
        keys = target.data.shape_keys
        names = distinct([self.name if len(layers) == 1 else f"{self.name}: {layer}" for layer, _ in layers])
        made = json.loads(target.data.get(MADE, "{}"))
        before = made.get(self.name, {})
        if any(keys.reference_key.name in (name, before.get(name)) for name in names):
            raise ValueError(f"“{keys.reference_key.name}” is the shape at rest: choose another name")
        now = {}
        for name, (_, displacement) in zip(names, layers):
            # Blender shortens long names.
            key = keys.key_blocks.get(before.get(name, name))
            if key is None or key.name in now.values():
                key = target.shape_key_add(name=name, from_mix=False)
            key.data.foreach_set("co", (rest + displacement).ravel())
            # One that was there may have been muted, limited, masked, or made relative to another key.
            key.relative_key, key.vertex_group, key.mute = keys.reference_key, "", False
            key.slider_min, key.slider_max = min(key.slider_min, 0.0), max(key.slider_max, 1.0)
            key.value = 1.0
            now[name] = key.name
        self.put_away(keys, before, now)
        # A key that is pinned hides what all others do.
        target.show_only_shape_key = False
        made[self.name] = before | now
        target.data[MADE] = json.dumps(made)
        target.data.update()
        return said

    @staticmethod
    def put_away(keys, before, now):
        """Sets the keys of an earlier run to 0 that this one has not renewed: they would add to the new ones."""
        for name in set(before.values()) - set(now.values()):
            key = keys.key_blocks.get(name)
            if key is not None and key != keys.reference_key:
                key.value = 0.0

    def end(self):
        """Stops the program where it still runs, and leaves nothing behind."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.folder.cleanup()


class ChladniCaricature(bpy.types.Operator):
    """Exaggerate what makes the mesh differ from its template, as a shape key"""

    bl_idname = "object.chladni_caricature"
    bl_label = "Caricature"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None or context.object.type != "MESH" or context.mode != "OBJECT":
            return False
        if context.object.data.library is not None:
            # Blender would not save its new keys.
            cls.poll_message_set("The mesh is linked from another file: make it local first")
            return False
        return True

    def begin(self, context):
        preferences = context.preferences.addons[__package__].preferences
        path = program(preferences)
        if not path:
            self.report({"ERROR"}, f"{why_missing(preferences)}: set its absolute path in the preferences")
            return None
        try:
            return Work(context.object, context.scene.chladni, path)
        except (OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return None

    def finish(self, work):
        try:
            said = work.take()
        except (OSError, ValueError, KeyError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            work.end()
        warning = "warning: "
        # Blender shows the last report, so warnings come last. The file that was written is gone by now.
        for line in sorted(said.splitlines(), key=lambda line: line.startswith(warning)):
            if line.startswith(warning):
                self.report({"WARNING"}, line.removeprefix(warning))
            elif not line.startswith("wrote "):
                self.report({"INFO"}, line)
        if work.is_uneven:
            applied = "apply the scale (Ctrl A) for a caricature of what is seen"
            self.report({"WARNING"}, f"The object is scaled unevenly: {applied}")
        return {"FINISHED"}

    def execute(self, context):
        work = self.begin(context)
        if work is None:
            return {"CANCELLED"}
        work.process.wait()
        return self.finish(work)

    def invoke(self, context, _event):
        self.work = self.begin(context)
        if self.work is None:
            return {"CANCELLED"}
        manager = context.window_manager
        self.timer = manager.event_timer_add(0.1, window=context.window)
        context.workspace.status_text_set("Chladni is at work; Escape stops it")
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        # As it is let go, it may have ended something else.
        stopped = event.type == "ESC" and event.value == "PRESS"
        if not stopped and self.work.process.poll() is None:
            return {"PASS_THROUGH"}
        if stopped:
            self.cancel(context)
            return {"CANCELLED"}
        self.rest(context)
        return self.finish(self.work)

    def rest(self, context):
        """No longer waits for the program."""
        context.window_manager.event_timer_remove(self.timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def cancel(self, context):
        """Ends the work; Blender calls this, too, where it ends the operator, as when another file is opened."""
        self.rest(context)
        self.work.end()


class ChladniPanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_chladni"
    bl_label = "Caricature"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Chladni"

    def draw(self, context):
        layout, settings = self.layout, context.scene.chladni
        layout.use_property_split = True
        layout.prop(settings, "template")
        if settings.template == "project":
            layout.prop(settings, "project")
        else:
            if settings.template == "object":
                layout.prop(settings, "other")
            layout.prop(settings, "model")
            layout.prop(settings, "mu")
            layout.prop(settings, "harmonics")
            if context.object is not None and context.object.type == "MESH":
                layout.prop_search(settings, "mask", context.object, "vertex_groups")
        layout.prop(settings, "keep_triangles")
        layout.prop(settings, "name")
        layout.operator(ChladniCaricature.bl_idname)


CLASSES = [ChladniPreferences, ChladniSettings, ChladniCaricature, ChladniPanel]


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.chladni = bpy.props.PointerProperty(type=ChladniSettings)


def unregister():
    del bpy.types.Scene.chladni
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
