"""Writes the rows of `chladni-bench limbs` and of `chladni-bench head-parts` into BENCHMARKS.md."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import write_section

text = f"""## Limbs

Made by `bench/limbs/run`; K = 256, level 0.3. Shapes are modeled of known limbs and a trunk; for each of them the best
intersection over union, by area, with a part that was found. Noise is 0.4 % of the half width, the pose twists the shape about
its axis by 43° where it is widest. Nested is the share of the area whose part at level 0.6 lies to nine tenths within one part of level 0.3.

| shape | change | limbs and trunk | parts found | least | mean | nested, % |
|---|---|---|---|---|---|---|
{pathlib.Path(sys.argv[1]).read_text()}"""
write_section("limbs", text)

write_section(
    "head-parts",
    f"""## Parts of heads

Made by `bench/limbs/run`. The parts of our own heads are known (docs/caricature.md, "Parts of a head"): the sample head, heads of
the sliders, and two that are bent as no slider bends one, their parts with them. For each part, intersection over union by area
of what `parts` finds, then its confidence. The sliders are those that `parts` fits: the rows of `portrait` that are not bent say
how well that goes where they can be met, the other three how well it goes where they cannot.

| head | nose | brow | eyes | mouth | chin | jaw | cheeks | ears | crown | neck | mean |
|---|---|---|---|---|---|---|---|---|---|---|---|
{pathlib.Path(sys.argv[2]).read_text()}""",
)
