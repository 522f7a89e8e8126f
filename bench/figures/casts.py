"""Who plays which part of the papers' figures: our own samples, or the meshes of the data folder.

Regions are balls in the shape's own units, views degrees to the right of the front and above the
horizon. A layer is (name, model, mu, region, further words of `chladni project add-layer`); an empty
region is everywhere.
"""

import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("CHLADNI_DATA", ROOT.parent / "shared" / "data")) / "meshes"


class Part:
    """A shape, where it is seen from, and regions of it by name."""

    def __init__(self, mesh, view, **regions):
        self.mesh, self.view, self.regions = mesh, view, regions

    def layer(self, region, model, mu, *words):
        return region, model, mu, self.regions[region], list(words)


# Features of the size of a chin, amplified: the scale control of Figures 7 and 10, over wavelengths in percent of the size.
MID = ("--scale-curve", "320%:0.4,92%:1,46%:2,28%:1,17%:0,4%:0,d:0")
ALL = "320%:1,4%:1,d:1"
# The last step of Figures 8 and 12: the shape itself, scaled down, as template.
MAGNIFY = ("all", "coordinate", -0.2, "", ["--template", "self:scale=0.8"])


def samples():
    head = Part("sample:head", "25,5", nose="0,-0.25,0.95,0.42", chin="0,-0.9,0.75,0.4", brow="0,0.2,0.75,0.45",
                ears="0.85,-0.05,0,0.4 -0.85,-0.05,0,0.4")
    template = Part("sample:template", "25,5", nose="0,-0.25,0.85,0.4", chin="0,-0.9,0.65,0.4", brow="0,0.2,0.75,0.45",
                    ears="0.8,-0.05,0,0.4 -0.8,-0.05,0,0.4")
    return {
        "caricature-5": head,
        "caricature-6": (head, "nose"),
        "caricature-7": (head, "nose", "chin"),
        "caricature-8": (head, template, [head.layer("nose", "normal", -0.7), head.layer("chin", "distance", -2),
                                          head.layer("ears", "coordinate", -1), MAGNIFY]),
        "caricature-10": (head, template, [head.layer("nose", "coordinate", -1.2), head.layer("chin", "normal", -0.8, *MID),
                                           head.layer("brow", "distance", -2.4)]),
        "caricature-11": (head, Part("sphere", ""), [head.layer("nose", "normal", -0.8),
                                                     head.layer("chin", "distance", -2)]),
        "caricature-12": (head, template, [head.layer("ears", "distance", -3), head.layer("nose", "normal", -0.8),
                                           head.layer("chin", "coordinate", -1)]),
        "caricature-13": (template, head, [template.layer("nose", "coordinate", -0.5),
                                           template.layer("chin", "distance", -1), template.layer("ears", "normal", -0.8)]),
        "caricature-14": (head, template),
        "music": ("sample:octopus", 256),
    }


def data():
    mesh = lambda name: str(DATA / name)
    face = Part(mesh("heads/face.obj"), "25,5", nose="0,166,10,3.2", chin="0,159,8,3.5", brow="0,171.5,9,5",
                ears="8,168,-2,4 -8,168,-2,4")
    max_planck = Part(mesh("heads/decimated-max.obj"), "25,5", nose="26,-12,-30,32", chin="18,-78,-15,32",
                      brow="28,30,-5,50", ears="120,-5,120,35 -60,-5,120,35")
    igea = Part(mesh("heads/igea.ply"), "25,5", nose="0.002,-0.006,0.046,0.012", chin="0.001,-0.03,0.042,0.012",
                mouth="0.001,-0.02,0.045,0.01", brow="0.002,0.012,0.044,0.016")
    demosthenes = Part(mesh("heads/demosthenes-low-res.obj"), "25,5", nose="0.18,1.07,0.9,0.24", beard="0.16,0.7,0.65,0.3",
                       brow="0.19,1.41,0.85,0.3")
    lion = Part(mesh("animals/lion.off"), "25,5", nose="40.48,0.42,-14.3,0.13", brow="40.5,0.72,-14.22,0.2",
                chin="40.54,0.25,-14,0.16")
    return {
        "caricature-5": face,
        "caricature-6": (face, "nose"),
        "caricature-7": (face, "nose", "chin"),
        "caricature-8": (demosthenes, face, [demosthenes.layer("nose", "distance", -1.8),
                                             demosthenes.layer("beard", "normal", -1.2), MAGNIFY]),
        "caricature-10": (lion, demosthenes, [lion.layer("nose", "distance", -1.2), lion.layer("brow", "normal", -0.8, *MID),
                                              lion.layer("chin", "coordinate", -0.5)]),
        "caricature-11": (face, lion, [face.layer("nose", "normal", -0.5), face.layer("chin", "coordinate", -0.6),
                                       face.layer("brow", "distance", -1.5)]),
        "caricature-12": (max_planck, igea, [max_planck.layer("ears", "distance", -4), max_planck.layer("nose", "normal", -1.5),
                                             max_planck.layer("chin", "coordinate", -1.2), MAGNIFY]),
        "caricature-13": (igea, max_planck, [igea.layer("mouth", "coordinate", -0.4), igea.layer("brow", "distance", -2),
                                             igea.layer("chin", "normal", -0.5)]),
        "caricature-14": (igea, max_planck),
        "music": (mesh("shapes/octopus-low.mesh"), 256),
    }


CASTS = {"samples": samples, "data": data}
