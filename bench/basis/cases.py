"""What is measured: meshes, numbers of harmonics, and which peers are asked."""

import numpy as np

ALL = ("scipy", "lapy", "slepc", "spectra")

# name, mesh below CHLADNI_DATA/meshes (or a function making one), K, peers
CASES = [
    ("suzanne", "shapes/suzanne.obj", 100, ALL),
    ("reference face", "heads/reference.obj", 100, ALL),
    ("spot", "animals/spot.obj", 256, ALL),
    ("armadillo", "shapes/armadillo.obj", 256, ALL),
    ("lion ×4", "lion4", 256, ALL),
    ("koala", "animals/koala.obj", 512, ("scipy", "slepc", "spectra")),
    ("lion ×4", "lion4", 1000, ("scipy", "spectra")),
    ("igea", "heads/igea.ply", 256, ("scipy",)),
    ("igea", "heads/igea.ply", 2400, ()),
]

# How many times as fast as the fastest peer in the same run a case is to be.
AIMS = {("lion ×4", 256): 25, ("koala", 512): 45, ("lion ×4", 1000): 90}

# The papers' own preprocessing times: model, n, K, seconds, and the mesh here that is nearest.
PAPERS = [
    ("heart (music, 2012)", 622, 256, "4", "shapes/suzanne.obj"),
    ("eight (music, 2012)", 766, 256, "3", "heads/reference.obj"),
    ("duck (music, 2012)", 2108, 256, "7", "animals/spot.obj"),
    ("spring (music, 2012)", 4695, 256, "116", "shapes/fertility.off"),
    ("dinosaur (music, 2012)", 14054, 533, "76", "shapes/armadillo.obj"),
    ("octa (music, 2012)", 15136, 529, "27", "shapes/armadillo.obj"),
    ("octopus (music, 2012)", 20351, 546, "132", "heads/face.obj"),
    ("alien (music, 2012)", 24988, 540, "235", "heads/face.obj"),
    ("david (music, 2012)", 24988, 804, "119", "heads/face.obj"),
    ("cat (music, 2012)", 30059, 271, "381", "lion4"),
    ("gargoyle (music, 2012)", 30059, 1052, "99", "lion4"),
    ("bunny (music, 2012)", 34834, 1070, "479", "lion4"),
    ("buste (music, 2012)", 37874, 1075, "255", "lion4"),
    ("blooby (music, 2012)", 42432, 1065, "558", "animals/koala.obj"),
    ("Planck, template Egea (caricature, 2010)", 49000, 512, "402", "animals/koala.obj"),
    ("Face 1, template Face 3 (caricature, 2010)", 49000, 512, "429", "animals/koala.obj"),
    ("egea (music, 2012)", 63739, 275, "724", "animals/koala.obj"),
    ("head (music, 2012)", 65002, 1607, "751", "animals/koala.obj"),
    ("armadillo (music, 2012)", 86488, 2376, "1052", "heads/igea.ply"),
    ("cow (music, 2012)", 97803, 256, "1082", "heads/igea.ply"),
]


def lion4(source, target):
    """lion.off with every triangle split into four at the middles of its sides (33,386 vertices)."""
    words = open(source).read().split()
    n, m = int(words[1]), int(words[2])
    positions = [tuple(map(float, words[4 + 3 * i : 7 + 3 * i])) for i in range(n)]
    corners = np.array(words[4 + 3 * n : 4 + 3 * n + 4 * m], dtype=int).reshape(m, 4)[:, 1:]
    middle = {}

    def between(a, b):
        key = (min(a, b), max(a, b))
        if key not in middle:
            middle[key] = len(positions)
            positions.append(tuple((p + q) / 2 for p, q in zip(positions[a], positions[b])))
        return middle[key]

    triangles = []
    for a, b, c in corners:
        ab, bc, ca = between(a, b), between(b, c), between(c, a)
        triangles += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    with open(target, "w") as out:
        out.write(f"OFF\n{len(positions)} {len(triangles)} 0\n")
        out.writelines("%.17g %.17g %.17g\n" % p for p in positions)
        out.writelines("3 %d %d %d\n" % t for t in triangles)
