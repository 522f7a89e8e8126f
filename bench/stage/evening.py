"""An evening on stage, for bench/stage/hour and bench/soak/run: plays it for so many minutes with the program and in the
folder given, and writes the section of BENCHMARKS.md."""

import json
import os
import random
import re
import socket
import statistics
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "bench"))
from section import machine, write_section  # noqa: E402

PORT = 47_110
SAMPLE_SECS = 5.0
# What would stop the show, or needs a person to go on.
LEFT_OUT = {"play", "hold-tempo"}
# Knobs, looks and sizes take what memory they take. To be compared, the program is brought to the same ones now and then
# and left alone for a while.
RESTS, REST_SECS = 7, 20.0
AT_REST = [
    ("stage", 1.0),
    ("leave", None),
    ("song", 1.0),
    ("bands", 128.0),
    ("harmonics", 0.0),
    ("grains", 20_000.0),
    ("sand", 0.0),
    ("look", "aurora"),
    ("form", "half-mask"),
    ("resonate", 1.0),
]


class Plan(NamedTuple):
    """What happens how often: messages an hour, and after how long the next song, size, loss and shape come."""

    command: str
    heading: str
    messages_per_hour: int
    song_secs: tuple
    size_secs: tuple
    loss_secs: float
    shape_secs: float


NEVER = float("inf")
# By the sections of BENCHMARKS.md.
PLANS = {
    "hour": Plan("bench/stage/hour", "An hour on stage", 2000, (40.0, 100.0), (30.0, 90.0), 300.0, NEVER),
    # Eight hours of the other in one.
    "soak": Plan("bench/soak/run", "Eight hours in one", 16000, (5.0, 12.0), (8.0, 24.0), 150.0, 120.0),
}


def controls():
    """Each address with a function that makes a random argument, from the page that the program prints."""
    page = (ROOT / "docs" / "controls.md").read_text()
    found = []
    for address, values in re.findall(r"^\| `(/chladni/[a-z-]+)` \| ([^|]*) \|", page, re.MULTILINE):
        if address.rsplit("/", 1)[1] in LEFT_OUT:
            continue
        span = re.match(r"(-?[\d.]+) to ([\d.]+)", values)
        if span:
            low, high = map(float, span.groups())
            found.append((address, lambda r, low=low, high=high: r.uniform(low, high)))
        elif values.startswith("0 or 1"):
            found.append((address, lambda r: float(r.random() < 0.5)))
        elif values.startswith("none"):
            found.append((address, lambda _: None))
        elif "," in values:
            names = [name.strip() for name in values.split(",")]
            found.append((address, lambda r, names=names: r.choice(names)))
        else:
            found.append((address, lambda r: float(r.randint(1, 12))))
    return found


def packet(address, argument):
    """One OSC message."""

    def text(words):
        raw = words.encode() + b"\0"
        return raw + b"\0" * (-len(raw) % 4)

    if argument is None:
        return text(address) + text(",")
    if isinstance(argument, str):
        return text(address) + text(",s") + text(argument)
    return text(address) + text(",f") + struct.pack(">f", argument)


def plug():
    """A sound device appears."""
    load = ["pactl", "load-module", "module-null-sink", "sink_name=null", "norewinds=1", "rate=48000"]
    subprocess.run(load, capture_output=True)


def unplug():
    """It is taken away."""
    subprocess.run(["pactl", "unload-module", "module-null-sink"], capture_output=True)


def xdotool(*arguments):
    """What it prints, word by word."""
    return subprocess.run(["xdotool", *map(str, arguments)], capture_output=True, text=True).stdout.split()


def resize(width, height):
    """Gives the window another size."""
    for window in xdotool("search", "--onlyvisible", "--name", "Chladni")[:1]:
        xdotool("windowsize", window, width, height)


def open_shape(path):
    """Another shape, through the window's own way to open files; whether that came up."""
    for window in xdotool("search", "--name", "^Chladni$")[:1]:
        xdotool("windowfocus", "--sync", window, "key", "ctrl+o")
    for _ in range(100):
        for window in xdotool("search", "--onlyvisible", "--name", "^Open")[:1]:
            xdotool("windowfocus", "--sync", window, "type", "--delay", 20, path)
            xdotool("key", "Return")
            return True
        time.sleep(0.1)
    return False


def standing(pid):
    """Resident megabytes, open files and threads of a process."""
    status = Path(f"/proc/{pid}/status").read_text()
    number = lambda name: int(re.search(rf"^{name}:\s+(\d+)", status, re.MULTILINE).group(1))  # noqa: E731
    return number("VmRSS") / 1024, len(os.listdir(f"/proc/{pid}/fd")), number("Threads")


def at_rest(hand, pid):
    """Resident megabytes once the same settings, gallery and size of the window have been there for a while."""
    for name, argument in AT_REST:
        hand.sendto(packet(f"/chladni/{name}", argument), ("127.0.0.1", PORT))
        time.sleep(0.05)
    resize(1200, 800)
    time.sleep(REST_SECS)
    return standing(pid)[0]


def evening(folder, chladni, secs, plan):
    """Runs the show; the program's own report, and what was seen from outside."""
    songs = []
    for index, kind in enumerate(["pinknoise tremolo 2 40", "pluck C3 tremolo 1 60", "brownnoise tremolo 3 70"]):
        songs.append(folder / f"song{index}.wav")
        subprocess.run(["sox", "-n", "-r", "44100", "-c", "2", songs[-1], "synth", "150", *kind.split(), "gain", "-6"], check=True)
    command = [chladni, "open", *map(str, songs), "--measure", str(secs)]
    with open(folder / "report.json", "wb") as report, open(folder / "errors", "wb") as errors:
        program = subprocess.Popen(command, stdout=report, stderr=errors)
    hand, table, rng = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), controls(), random.Random(2012)
    gap_secs = 3600.0 / plan.messages_per_hour
    shapes = [folder / f"{name}.ply" for name in ("jellyfish", "cat", "octopus")] if plan.shape_secs < NEVER else []
    for shape in shapes:
        layer = [f"sample:{shape.stem}", "ellipsoid", "--mu", "0", "-k", "32", "-o", shape]
        subprocess.run([chladni, "caricature", *layer], check=True, capture_output=True)
    began = time.monotonic()
    samples, sent, resized, unplugged, opened = [], 0, 0, 0, 0
    next_sample, next_song, next_size, next_loss, next_shape, plug_at = 0.0, 60.0, 45.0, 240.0, plan.shape_secs, None
    # The last with time left for it before the program ends by itself.
    rests, rest_every = [], (secs - 2.0 * REST_SECS) / RESTS
    while program.poll() is None:
        now = time.monotonic() - began
        if now >= sent * gap_secs:
            address, argument = rng.choice(table)
            hand.sendto(packet(address, argument(rng)), ("127.0.0.1", PORT))
            sent += 1
        if now >= next_sample:
            try:
                samples.append((now, *standing(program.pid)))
            except (FileNotFoundError, AttributeError):
                break
            next_sample += SAMPLE_SECS
        if now >= next_song:
            hand.sendto(packet("/chladni/song", float(rng.randint(1, len(songs)))), ("127.0.0.1", PORT))
            next_song += rng.uniform(*plan.song_secs)
        if now >= next_size:
            resize(rng.randint(900, 1500), rng.randint(620, 950))
            resized, next_size = resized + 1, next_size + rng.uniform(*plan.size_secs)
        if now >= next_loss:
            unplug()
            unplugged, plug_at, next_loss = unplugged + 1, now + 4.0, next_loss + plan.loss_secs
        if now >= next_shape:
            # On stage its keys are others.
            hand.sendto(packet("/chladni/leave", None), ("127.0.0.1", PORT))
            time.sleep(1.0)
            opened += open_shape(shapes[opened % len(shapes)])
            next_shape = now + plan.shape_secs
        if plug_at is not None and now >= plug_at:
            plug()
            plug_at = None
        if plug_at is None and len(rests) < RESTS and now >= (len(rests) + 1) * rest_every:
            rests.append(at_rest(hand, program.pid))
        time.sleep(0.05)
    if program.wait():
        sys.exit((folder / "errors").read_text())
    report = json.loads((folder / "report.json").read_text())
    report.update(messages=sent, resized=resized, unplugged=unplugged, opened=opened, samples=len(samples), at_rest_mb=rests)
    for index, name in enumerate(["resident_mb", "open_files", "threads"], start=1):
        # Once all is loaded and has been seen: from a sixth of the time on.
        later = [sample[index] for sample in samples[len(samples) // 6 :]]
        tenth = max(len(later) // 10, 1)
        report[name] = {
            "early": statistics.median(later[:tenth]),
            "late": statistics.median(later[-tenth:]),
            "most": max(later),
            "twelfths": [
                round(statistics.median(sample[index] for sample in part), 1)
                for part in (samples[len(samples) * i // 12 : len(samples) * (i + 1) // 12] for i in range(12))
                if part
            ],
        }
    return report


def replayed(folder, chladni, secs):
    """Films the end, the middle and the beginning of the log that the window kept of the show, twice each; how many actions it
    has, frames that were filmed, and whether both films are the same."""
    logs = sorted((folder / "state").rglob("show*.toml"), key=lambda path: path.stat().st_mtime)
    if not logs:
        return None
    frames, same = 0, True
    for part in (0.9, 0.5, 0.05):
        first = int(30.0 * part * secs)
        films = []
        for number in range(2):
            out = folder / f"film{first}-{number}"
            command = [chladni, "--quiet", "dance", "--show", logs[-1], "--frames", out, "--size", "160x90", "--piece", f"{first}..{first + 60}"]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"the show's log does not play: {done.stderr}")
            films.append([path.read_bytes() for path in sorted(out.glob("*.png"))])
        frames, same = frames + len(films[0]), same and films[0] == films[1]
    return {"actions": logs[-1].read_text().count("[[actions]]"), "frames": frames, "same": same}


def main():
    chladni, folder, minutes, section = sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
    plan = PLANS[section]
    (folder / "chladni").mkdir()
    (folder / "chladni" / "settings.toml").write_text(f"[music]\nosc_port = {PORT}\n")
    report = evening(folder, chladni, 60.0 * minutes, plan)
    log = report["replayed"] = replayed(folder, chladni, report["secs"])
    print(json.dumps(report))
    grown = lambda name: f"{report[name]['early']:,.0f} → {report[name]['late']:,.0f} (most {report[name]['most']:,.0f})"  # noqa: E731
    write_section(
        section,
        f"""## {plan.heading}

{machine()}; Xvfb, drawn by the processor unless a card is there, sound into a PulseAudio null sink. Early is the first tenth of the time after a warm-up of a sixth, late the last. Made by `{plan.command} {minutes:g}`.

| what | measured |
|---|---|
| time | {report["secs"] / 60:.1f} min |
| control messages, window resizes, sound devices lost, shapes opened | {report["messages"]}, {report["resized"]}, {report["unplugged"]}, {report["opened"]} |
| resident memory at the same settings, MB | {", ".join(f"{mb:,.0f}" for mb in report["at_rest_mb"])} |
| resident memory, MB | {grown("resident_mb")} |
| the same in each twelfth of the time | {", ".join(f"{mb:,.0f}" for mb in report["resident_mb"]["twelfths"])} |
| open files | {grown("open_files")} |
| threads | {grown("threads")} |
| frames | {report["frames"]:,} ({report["frames"] / report["secs"]:.1f} a second) |
| pause between two frames, median of each quarter of the time | {", ".join(f"{1e3 * s:.0f}" for s in report["median_quarters_secs"])} ms |
| longest | {report["longest_frame_secs"]:.3f} s |
| times the device had nothing to play | {report["underruns"]} |
| actions in the show's log; frames filmed from it in three places, twice | {f"{log['actions']:,}; {log['frames']}, {'the same' if log['same'] else 'which differ'}" if log else "none was kept"} |""",
    )


main()
