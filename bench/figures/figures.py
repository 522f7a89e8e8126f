"""What the papers' figures show, made by the program itself in paper mode: see `run`."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from casts import ALL, CASTS, MID

CHLADNI = os.environ["CHLADNI"]
HARMONICS = 512
MODELS = ["coordinate", "normal", "distance"]
MODEL_NAMES = ["coordinate-wise", "normal displacement", "distance minimizing"]
# Pixels of a panel.
WIDE, HIGH = 240, 280


def chladni(*words):
    done = subprocess.run([CHLADNI, "--quiet", *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"chladni {' '.join(map(str, words))}: {done.stderr}{done.stdout}")


def mu_is(mu):
    return f"μ = {mu:g}".replace("-", "−")


class Sheet:
    """Makes the figures of one cast."""

    def __init__(self, cast, out, work):
        self.cast, self.out, self.work = cast, out, work

    # Pictures of the program.

    def panels(self, part, template, panels, *words, rows=1, recipe=None, steps=None):
        """Rows of panels as arrays, all of one call to one scale."""
        result, picture = self.work / "result.ply", self.work / "panels.png"
        columns = len(panels) if steps is None else steps
        what = ["--recipe", recipe] if recipe else [part.mesh, template, "--paper", "--harmonics", HARMONICS]
        chladni("caricature", *what, *words, "-o", result, "--render", picture, "--show", ",".join(panels),
                f"--view={part.view}", "--size", f"{columns * WIDE}x{rows * HIGH}")
        image = np.asarray(Image.open(picture).convert("RGB"))
        cut = lambda row, column: image[row * HIGH : (row + 1) * HIGH, column * WIDE : (column + 1) * WIDE]
        return [[cut(row, column) for column in range(columns)] for row in range(rows)]

    def recipe(self, part, template, layers):
        """A project with these layers, lowest first."""
        path = self.work / "recipe.chladni"
        path.unlink(missing_ok=True)
        chladni("project", "new", part.mesh, "--paper", "--harmonics", HARMONICS, "-o", path)
        for name, model, mu, region, words in layers:
            regions = [f"--region={ball}" for ball in region.split()]
            against = [] if "--template" in words else ["--template", template]
            chladni("project", "add-layer", path, *against, "--name", name, "--model", model, f"--mu={mu}", *regions, *words)
        return path

    # Pages.

    def page(self, name, rows, titles=None, labels=None, scale=1.0, curves=None):
        """Panels on a page; `curves` draws into the panels that are None."""
        columns = max(map(len, rows))
        high, wide = rows[0][0].shape[:2]
        width = scale * WIDE / 100
        figure, axes = plt.subplots(len(rows), columns, squeeze=False, dpi=100,
                                    figsize=(columns * width + 0.4, len(rows) * width * high / wide + 0.3))
        for i, row in enumerate(rows):
            for j, axis in enumerate(axes[i]):
                axis.axis("off")
                if j >= len(row):
                    continue
                if row[j] is None:
                    curves(axis, i, j)
                else:
                    axis.imshow(row[j])
                if titles and i == 0 and j < len(titles):
                    axis.set_title(titles[j], fontsize=10)
            if labels:
                axes[i][0].text(-0.03, 0.5, labels[i], transform=axes[i][0].transAxes, rotation=90, ha="right", va="center",
                                fontsize=10)
        figure.subplots_adjust(left=0.35 / figure.get_figwidth(), right=0.995, bottom=0.005,
                               top=1 - 0.28 / figure.get_figheight(), wspace=0.02, hspace=0.02)
        self.save(figure, name)

    def save(self, figure, name):
        path = self.out / f"figure-{name}.jpg"
        figure.savefig(path, pil_kwargs={"quality": 88, "subsampling": 0, "optimize": True})
        plt.close(figure)
        print(f"{path}: {path.stat().st_size // 1000} kB")


class Caricature(Sheet):
    def caricature_5(self):
        """μ from −0.3 to −0.6 against an ellipsoid, in the three models."""
        part, sweep = self.cast["caricature-5"], [-0.3, -0.4, -0.6]
        rows = self.panels(part, "ellipsoid", MODELS, f"--sweep={','.join(map(str, sweep))}", rows=3)
        self.page("caricature-5", rows, MODEL_NAMES, [mu_is(mu) for mu in sweep])

    def caricature_6(self):
        """χ01, χ cut at three frequencies, and the three models in it."""
        part, region = self.cast["caricature-6"]
        rows = []
        for cutoff in [32, 96, 192]:
            balls = [f"--region={ball}" for ball in part.regions[region].split()]
            rows += self.panels(part, "ellipsoid", ["painted", "region", *MODELS], *balls, "--cutoff", cutoff, "--mu=-0.8")
        self.page("caricature-6", rows, ["χ01", "χ", *MODEL_NAMES], ["nχ = 32", "nχ = 96", "nχ = 192"], scale=0.8)

    def caricature_7(self):
        """The result of Figure 6 as the new shape: the chin with all scales, and with the middle ones."""
        part, first, second = self.cast["caricature-7"]
        panels, curves = [], []
        for words in [[], MID]:
            layers = [part.layer(first, "normal", -0.8), part.layer(second, "normal", -0.8, *words)]
            recipe = self.recipe(part, "ellipsoid", layers)
            panels.append(self.panels(part, None, ["region", "after"], recipe=recipe)[0])
            curves.append(words[1] if words else ALL)
        row = [panels[0][0], panels[0][1], None, panels[1][1], None]
        self.page("caricature-7", [row], ["χ on the result of Figure 6", "all scales", "Φ", "middle scales", "Φ"], scale=0.8,
                  curves=lambda axis, i, j: plot_curve(axis, curves[0 if j == 2 else 1]))

    def steps(self, name):
        part, template, layers = self.cast[name]
        recipe = self.recipe(part, template.mesh, layers)
        row = self.panels(part, None, ["steps"], recipe=recipe, steps=len(layers) + 1)[0]
        titles = ["the shape", *(f"{name}: {model}, {mu_is(mu)}" for name, model, mu, _, _ in layers)]
        self.page(name, [row], titles)

    def caricature_8(self):
        """One feature after the other, at last all of them at once."""
        self.steps("caricature-8")

    def independent(self, name):
        part, template, layers = self.cast[name]
        rows, labels, curves = [], [], {}
        for i, layer in enumerate(layers):
            recipe = self.recipe(part, template.mesh, [layer])
            rows.append(self.panels(part, None, ["before", "painted", "region", "after"], recipe=recipe)[0])
            words = layer[4]
            curve = words[words.index("--scale-curve") + 1] if "--scale-curve" in words else ALL
            curves[i] = curve
            rows[-1].insert(3, None)
            labels.append(f"{layer[1]}, {mu_is(layer[2])}")
        self.page(name, rows, ["the shape", "χ01", "χ, nχ = 96", "Φ", "the caricature"], labels, scale=0.8,
                  curves=lambda axis, i, j: plot_curve(axis, curves[i]))

    def caricature_10(self):
        """Caricatures of their own, with χ01, χ and Φ as vignettes."""
        self.independent("caricature-10")

    def caricature_11(self):
        """The same against a template of another kind."""
        self.independent("caricature-11")

    def caricature_12(self):
        self.steps("caricature-12")

    def caricature_13(self):
        self.steps("caricature-13")

    def caricature_14(self):
        """μ from 1 to −1 between two heads and back, in the three models, with no other control."""
        first, second = self.cast["caricature-14"]
        sweep = [1, 0.5, 0, -0.5, -1]
        both = [self.panels(part, other.mesh, MODELS, f"--sweep={','.join(map(str, sweep))}", rows=5)
                for part, other in [(first, second), (second, first)]]
        rows = [left + right for left, right in zip(*both)]
        self.page("caricature-14", rows, MODEL_NAMES * 2, [mu_is(mu) for mu in sweep], scale=0.7)


def plot_curve(axis, text):
    """Φ as `--scale-curve` takes it, over wavelengths; d is the residual, drawn as a dot beyond the harmonics."""
    points = dict(point.split(":") for point in text.split(","))
    residual = float(points.pop("d"))
    axis.axis("on")
    axis.plot([float(p.rstrip("%")) for p in points], [float(p) for p in points.values()], color="tab:blue")
    axis.plot([2.8], [residual], "o", color="tab:blue")
    axis.axhline(1, color="0.8", zorder=0)
    axis.set(xscale="log", xlim=(400, 2.2), ylim=(-0.1, 2.2), yticks=[0, 1, 2])
    axis.set_xticks([100, 30, 10], ["100 %", "30", "10"])
    axis.set_xticks([], minor=True)
    axis.tick_params(labelsize=7, direction="in")
    axis.tick_params(axis="y", pad=-12)
    axis.set_box_aspect(0.7)


class Music(Sheet):
    MOMENT = ["--start", 6, "--duration", 1, "--fps", 1]

    def dance(self, *words, size="1200x800", name="frames"):
        """The frame of the moment that all figures of music show."""
        mesh, harmonics = self.cast["music"]
        folder = self.work / name
        chladni("dance", mesh, "sample:tune", "--paper", "-k", harmonics, "--frames", folder, *self.MOMENT, "--size", size,
                "--samples", 4, "--look", "plain", "--lights", "studio", "--material", "clay", "--background", "white", "--gain", 4, *words)
        return np.asarray(Image.open(folder / "frame-00000.png").convert("RGB"))

    def session(self, *actions):
        path = self.work / "session.toml"
        lines = ["format_version = 1", "seed = 1", "size = 6"]
        for action in actions:
            lines += ["[[actions]]", "at_secs = 0.0", "at_beat = 0.0", *action]
        path.write_text("\n".join(lines) + "\n")
        return path

    def presets(self, folder):
        mappings = [tomllib.loads(path.read_text())["mapping"] for path in sorted(folder.glob("item-*.toml"))]
        return [(np.array(m["transfer"]), np.array(m["amplification"])) for m in mappings]

    def spectrum(self):
        out = subprocess.run([CHLADNI, "--quiet", "spectrum", "sample:tune", "--json", "--linear", "--start", "6",
                              "--duration", "1"], capture_output=True, text=True, check=True).stdout
        return np.array(json.loads(out)["frames"][0]["mid"])

    def gallery(self, name, *words):
        folder = self.work / "presets"
        frame = self.dance("--presets", folder, *words)
        mappings, spectrum = self.presets(folder), self.spectrum()
        height, width = frame.shape[0] // 2, frame.shape[1] // 3
        figure = plt.figure(figsize=(10.2, 5.6), dpi=100)
        grid = figure.add_gridspec(3, 9, height_ratios=[4, 4, 1], width_ratios=[1, 4, 1] * 3, wspace=0.05, hspace=0.12,
                                   left=0.01, right=0.99, top=0.99, bottom=0.06)
        rainbow = plt.get_cmap("rainbow")
        for i, (transfer, amplification) in enumerate(mappings):
            row, column = divmod(i, 3)
            left, middle, right = (figure.add_subplot(grid[row, 3 * column + j]) for j in range(3))
            cell = frame[row * height : (row + 1) * height, column * width : (column + 1) * width]
            margin = width // 12
            middle.imshow(cell[margin:-margin, margin:-margin])
            rise = np.linspace(0, 1, len(amplification))
            left.scatter(amplification, rise, c=rainbow(rise), s=2)
            left.set(xlim=(-1.1, 1.1), ylim=(-0.05, 1.05))
            across = np.linspace(0, 1, len(transfer))
            right.scatter(across, transfer, c=rainbow(across), s=2)
            right.set(xlim=(-0.05, 1.05), ylim=(-0.05, 1.05))
            for axis in (left, right):
                axis.set(xticks=[], yticks=[])
            middle.axis("off")
        below = figure.add_subplot(grid[2, :])
        below.bar(np.arange(len(spectrum)), spectrum, color=rainbow(np.linspace(0, 1, len(spectrum))), width=1)
        below.set(xlim=(-1, len(spectrum)), xticks=[], yticks=[], xlabel="f̃(ω) of the moment")
        self.save(figure, name)

    def music_3(self):
        """A filter as transfer t and amplification a, the direct mapping in gray."""
        mesh, harmonics = self.cast["music"]
        folder = self.work / "presets"
        self.dance("--gallery", 6, "--presets", folder, size="300x200")
        (transfer, _), (_, amplification) = self.presets(folder)[1], self.presets(folder)[1]
        archive = self.work / "basis.npz"
        chladni("basis", mesh, "--paper", "-k", harmonics, "-o", archive)
        frequency = np.sqrt(np.maximum(np.load(archive)["eigenvalues"], 0))
        figure, (left, right) = plt.subplots(1, 2, figsize=(7, 3.2), dpi=100, sharey=True, width_ratios=[1, 2.2])
        k = np.arange(harmonics)
        rise = np.linspace(0, 1, len(amplification))
        rainbow = plt.get_cmap("rainbow")
        left.scatter(amplification, rise * (harmonics - 1), c=rainbow(rise), s=6)
        left.set(xlabel="a(k)", ylabel="k", xlim=(-1.1, 1.1))
        across = np.linspace(0, 1, len(transfer))
        right.plot(frequency / frequency[-1], k, color="0.7", label="ω ≅ √Λ")
        right.scatter(across, transfer * (harmonics - 1), c=rainbow(across), s=6, label="t(ω)")
        right.set(xlabel="ω / ω_max")
        right.legend(frameon=False)
        figure.tight_layout()
        self.save(figure, "music-3")

    def music_4(self):
        """The first gallery, each item's amplification to the left and its transfer to the right."""
        self.gallery("music-4", "--gallery", 6)

    def music_5(self):
        """The gallery bred from items 1, 4 and 5."""
        chosen = [[f'do = "choose"', f"item = {item}", "on = true"] for item in [0, 3, 4]]
        self.gallery("music-5", "--session", self.session(*chosen, ['do = "breed"']))

    def classes(self):
        mesh, _ = self.cast["music"]
        picture = self.work / "symmetry.png"
        chladni("symmetry", mesh, "--paper", "-k", 64, "--render", picture)
        image = np.asarray(Image.open(picture).convert("RGB"))
        height, width = image.shape[0] // 3, image.shape[1] // 4
        return [image[r * height : (r + 1) * height, c * width : (c + 1) * width] for r in range(3) for c in range(4)]

    def music_6(self):
        """Harmonics of low frequency, the flag warm where symmetric and cool where antisymmetric."""
        cells = self.classes()[1:9]
        self.page("music-6", [cells[:4], cells[4:]])

    def music_7(self):
        """Only antisymmetric harmonics, and only symmetric ones, over the shape at rest as dots."""
        folder = self.work / "presets"
        self.dance("--presets", folder, size="80x80")
        # Without a gallery the first item is the direct mapping.
        direct = tomllib.loads((folder / "item-01.toml").read_text())["mapping"]
        mapping = "{ " + ", ".join(f"{key} = {value}" for key, value in direct.items()) + " }"
        row = []
        for choir in ["antisymmetric", "symmetric"]:
            load = ['do = "load"', "item = 0", 'name = "direct"', f"mapping = {mapping}"]
            session = self.session(load, ['do = "set-choir"', f'choir = "{choir}"'], ['do = "perform"', "item = 0"])
            frame = self.dance("--session", session, "--rest", size="800x800")
            row.append(frame[20:-100, 60:-60])
        self.page("music-7", [row], ["antisymmetric harmonics only", "symmetric harmonics only"], scale=1.3)

    def music_8(self):
        """How often each vertex is an extremum of the first 15 harmonics, and the pairs in colors of their own."""
        self.page("music-8", [self.classes()[:1]], scale=1.6)


FIGURES = [f"caricature-{i}" for i in (5, 6, 7, 8, 10, 11, 12, 13, 14)] + [f"music-{i}" for i in range(3, 9)]


def main():
    cast, out, *wanted = sys.argv[1:]
    if cast not in CASTS or any(name not in FIGURES for name in wanted):
        raise SystemExit(f"a cast is one of {', '.join(CASTS)}, a figure one of {', '.join(FIGURES)}")
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    parts = CASTS[cast]()
    for name in wanted or FIGURES:
        kind = Music if name.startswith("music") else Caricature
        with tempfile.TemporaryDirectory() as work:
            sheet = kind(parts, out, pathlib.Path(work))
            getattr(sheet, name.replace("-", "_"))()


if __name__ == "__main__":
    main()
