"""Writes what the example `twins` prints into BENCHMARKS.md."""

import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from section import processor, write_section  # noqa: E402

HEAD = """## The processor beside the graphics device

`bench/draw/run` on {machine}. Levels of detail off, four samples a pixel on both. Milliseconds of a frame: the median of 21, the
best, the processor time of all threads together, and times the first column's median. The load of the machine was {load:.1f} when
it began; where that is more than 0, ratios and the best say more than medians. Each effect (docs/looks.md) is drawn beside the shadow of
*one shape* alone; the last two rows are whole looks.
"""


def main():
    load = os.getloadavg()[0]
    done = subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True)
    lines = done.stdout.splitlines()
    devices = [line for line in lines if not line.startswith("|")]
    table = [line for line in lines if line.startswith("|")]
    rule = "|" + "---|" * (table[0].count("|") - 1)
    said = "Columns: " + "; ".join(devices) + "."
    text = "\n".join([HEAD.format(machine=processor(), load=load), said, "", table[0], rule, *table[1:]])
    write_section("draw", text)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
