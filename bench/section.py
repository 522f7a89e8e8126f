"""A benchmark's section of BENCHMARKS.md, between `<!-- NAME:begin -->` and `<!-- NAME:end -->`."""

import os
import pathlib
import platform

BENCHMARKS = pathlib.Path(__file__).resolve().parents[1] / "BENCHMARKS.md"


def write_section(name, text, path=BENCHMARKS):
    """Replaces the section, or adds it at the end."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    old = path.read_text() if path.exists() else "# Benchmarks\n"
    section = f"{begin}\n{text.strip()}\n{end}"
    if begin in old and end in old:
        new = old[: old.index(begin)] + section + old[old.index(end) + len(end) :]
    else:
        new = f"{old.rstrip()}\n\n{section}\n"
    path.write_text(new)


def processor():
    """The processor's name and how many of it there are."""
    name = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        name = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), name)
    return f"{name}, {os.cpu_count()} cores"


def machine():
    """The processor and how busy it is: above its number of cores, times are upper bounds."""
    return f"{processor()}, load average {os.getloadavg()[0]:.1f}"
