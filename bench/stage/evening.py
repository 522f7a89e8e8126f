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
from verdicts import surprises, verdicts  # noqa: E402

PORT = 47_110
SAMPLE_SECS = 5.0
# What would stop the show, or needs a person to go on.
LEFT_OUT = {"play", "hold-tempo"}
# What chooses songs, or how they follow each other.
SONGS = {"song", "next-song", "previous-song", "shuffle", "repeat", "live"}
# Knobs, looks, sizes and shapes take what memory they take. To be compared, the program is brought to the same ones now
# and then, with the first song, and left alone for a while. All that the page of controls has a first value for gets it.
REST_SECS = 20.0
AT_REST = [
    ("stage", 1.0),
    ("leave", None),
    ("song", "song0"),
    ("repeat", "list"),
    ("harmonics", 0.0),
    ("choir", "all"),
    ("blur", 0.0),
    ("song-fade", 0.0),
    ("look", "aurora"),
    ("form", "half-mask"),
]
# A recording that began just now needs a moment to be noticed, and one that ends to be written.
RECORDING_BEGINS_SECS, RECORDING_ENDS_SECS = 3.0, 60.0
# The last songs are short. In the middle between two rests nobody chooses another for a while, so that they end by themselves.
SONG_SECS = [150, 150, 150, 7, 9, 8]
LEFT_ALONE = 0.3
# A shape takes a while to open, and the log of the show is written a few seconds after a change, at most half a minute.
LOG_SECS = 60.0


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
    """Each address with a function that makes a random argument, and those with a first value with that, from the page that
    the program prints."""
    page = (ROOT / "docs" / "controls.md").read_text()
    found, first = [], []
    for address, values in re.findall(r"^\| `(/chladni/[a-z-]+)` \| ([^|]*) \|", page, re.MULTILINE):
        if address.rsplit("/", 1)[1] in LEFT_OUT:
            continue
        at_first = re.search(r"at first (-?[\d.]+)", values)
        if at_first:
            first.append((address.rsplit("/", 1)[1], float(at_first.group(1))))
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
    return found, first


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
    """Resident megabytes, open files and threads of a process; `None` once it ends."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
        number = lambda name: int(re.search(rf"^{name}:\s+(\d+)", status, re.MULTILINE).group(1))  # noqa: E731
        return number("VmRSS") / 1024, len(os.listdir(f"/proc/{pid}/fd")), number("Threads")
    except (OSError, AttributeError):
        return None


def is_recording(pid):
    """Whether a set is being recorded, by the names of the program's threads."""
    names = subprocess.run(["ps", "-L", "-o", "comm=", "-p", str(pid)], capture_output=True, text=True).stdout
    return "recording" in names.split()


def at_rest(hand, pid, settings):
    """Resident megabytes, open files and threads once the same settings, gallery and size of the window have been there for
    a while, and nothing is recorded."""
    time.sleep(RECORDING_BEGINS_SECS)
    if is_recording(pid):
        hand.sendto(packet("/chladni/record", None), ("127.0.0.1", PORT))
        until = time.monotonic() + RECORDING_ENDS_SECS
        while is_recording(pid) and time.monotonic() < until:
            time.sleep(0.1)
    for name, argument in settings:
        hand.sendto(packet(f"/chladni/{name}", argument), ("127.0.0.1", PORT))
        time.sleep(0.05)
    resize(1200, 800)
    time.sleep(REST_SECS)
    return standing(pid)


def logs(folder):
    """Those that windows kept of their shows, the newest first."""
    found = []
    for path in (folder / "state").rglob("show*.toml"):
        try:
            found.append((path.stat().st_mtime, path))
        except FileNotFoundError:
            # It is replaced just now.
            pass
    return [path for _, path in sorted(found, reverse=True)]


def log_of(folder):
    """The newest log's text."""
    for path in logs(folder):
        try:
            return path.read_text()
        except FileNotFoundError:
            pass
    return ""


class Shapes:
    """Opens shapes, the first of them with the program, and counts those that the log of the show then names."""

    def __init__(self, folder, chladni):
        self.folder, self.asked, self.opened, self.awaited, self.until = folder, 0, 0, None, 0.0
        self.paths = [folder / f"{name}.ply" for name in ("jellyfish", "cat", "octopus")]
        self.shown = self.paths[0]
        for path in self.paths:
            layer = [f"sample:{path.stem}", "ellipsoid", "--mu", "0", "-k", "32", "-o", path]
            subprocess.run([chladni, "caricature", *layer], check=True, capture_output=True)

    def open(self, hand, path):
        """Asks for one, unless it is shown. On stage its keys are others."""
        if path == self.shown:
            return
        hand.sendto(packet("/chladni/leave", None), ("127.0.0.1", PORT))
        time.sleep(1.0)
        self.asked, self.shown = self.asked + 1, None
        if open_shape(path):
            self.awaited, self.until = path, time.monotonic() + LOG_SECS

    def look(self):
        """Whether it is known what came of the last."""
        if self.awaited and f'/{self.awaited.name}"' in log_of(self.folder):
            self.opened, self.shown, self.awaited = self.opened + 1, self.awaited, None
        elif self.awaited and time.monotonic() > self.until:
            self.awaited = None
        return self.awaited is None

    def wait(self, hand):
        """Until that is known. Only a show that has changed has a log: a knob moves meanwhile."""
        gain = 1.0
        while not self.look():
            gain = 2.1 - gain
            hand.sendto(packet("/chladni/gain", gain), ("127.0.0.1", PORT))
            time.sleep(1.0)


def begin_list(hand, folder):
    """A short song, then those after it. Returns how often a song had been heard once the log has it."""
    for name, argument in [("repeat", "list"), ("song-fade", 0.0), ("song", "song3")]:
        hand.sendto(packet(f"/chladni/{name}", argument), ("127.0.0.1", PORT))
        time.sleep(0.05)
    time.sleep(0.7 * min(SONG_SECS))
    return log_of(folder).count("[[heard]]")


def songs_of(folder):
    """Files of noise and of a string, each of another length."""
    kinds = ["pinknoise tremolo 2 40", "pluck C3 tremolo 1 60", "brownnoise tremolo 3 70"]
    songs = []
    for index, secs in enumerate(SONG_SECS):
        songs.append(folder / f"song{index}.wav")
        form = ["-r", "44100", "-c", "2", songs[-1], "synth", str(secs)]
        subprocess.run(["sox", "-n", *form, *kinds[index % len(kinds)].split(), "gain", "-6"], check=True)
    return songs


def evening(folder, chladni, secs, plan):
    """Runs the show; the program's own report, and what was seen from outside."""
    songs = songs_of(folder)
    shapes = Shapes(folder, chladni) if plan.shape_secs < NEVER else None
    # The first song and the first shape are those of the rests.
    first = [songs[0], *([shapes.paths[0]] if shapes else []), *songs[1:]]
    command = [chladni, "open", *map(str, first), "--measure", str(secs)]
    with open(folder / "report.json", "wb") as report, open(folder / "errors", "wb") as errors:
        program = subprocess.Popen(command, stdout=report, stderr=errors)
    hand, (table, at_first), rng = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), controls(), random.Random(2012)
    gap_secs = 3600.0 / plan.messages_per_hour
    began = time.monotonic()
    samples, sent, resized, followed = [], 0, 0, 0
    next_sample, next_song, next_size, next_loss, next_shape, plug_at = 0.0, 60.0, 45.0, 240.0, plan.shape_secs, None
    # The last with time left for it before the program ends by itself.
    rests, wanted_rests = [], max(3, min(7, round(secs / 150.0)))
    rest_every = (secs - 4.0 * REST_SECS) / wanted_rests
    # When a device went and came again, and how many songs had been heard when the songs were left alone.
    absences, heard = [], None
    while program.poll() is None:
        now = time.monotonic() - began
        since_rest = (now - len(rests) * rest_every) / rest_every
        alone = abs(since_rest - 0.5) < LEFT_ALONE / 2.0
        if alone != (heard is not None):
            if alone:
                heard = begin_list(hand, folder)
            else:
                followed += max(0, log_of(folder).count("[[heard]]") - heard)
                heard = None
        if now >= sent * gap_secs:
            address, argument = rng.choice(table)
            if not (alone and address.rsplit("/", 1)[1] in SONGS):
                hand.sendto(packet(address, argument(rng)), ("127.0.0.1", PORT))
            sent += 1
        if now >= next_sample:
            stood = standing(program.pid)
            if stood is None:
                break
            samples.append((now, *stood))
            next_sample += SAMPLE_SECS
            if shapes:
                shapes.look()
        if now >= next_song and not alone:
            hand.sendto(packet("/chladni/song", float(rng.randint(1, len(songs)))), ("127.0.0.1", PORT))
            next_song = now + rng.uniform(*plan.song_secs)
        if now >= next_size:
            resize(rng.randint(900, 1500), rng.randint(620, 950))
            resized, next_size = resized + 1, next_size + rng.uniform(*plan.size_secs)
        if now >= next_loss:
            absences.append((time.time(), NEVER))
            unplug()
            plug_at, next_loss = now + 4.0, next_loss + plan.loss_secs
        if shapes and now >= next_shape and not alone:
            shapes.wait(hand)
            shapes.open(hand, rng.choice([path for path in shapes.paths if path != shapes.shown]))
            next_shape = now + plan.shape_secs
        if plug_at is not None and now >= plug_at:
            plug()
            absences[-1] = (absences[-1][0], time.time())
            plug_at = None
        if plug_at is None and len(rests) < wanted_rests and now >= (len(rests) + 1) * rest_every:
            if shapes:
                shapes.wait(hand)
                shapes.open(hand, shapes.paths[0])
                shapes.wait(hand)
            stood = at_rest(hand, program.pid, at_first + AT_REST)
            if stood is None:
                break
            rests.append(stood)
        time.sleep(0.05)
    if program.wait():
        sys.exit((folder / "errors").read_text())
    report = json.loads((folder / "report.json").read_text())
    # What came of the last may not be known yet.
    asked, opened = (shapes.asked - bool(shapes.awaited), shapes.opened) if shapes else (0, 0)
    report.update(messages=sent, resized=resized, unplugged=len(absences), asked=asked, opened=opened, followed=followed)
    report.update(samples=len(samples), rests=rests, surprises=surprises(report["underruns_at"], absences))
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
    log = next(iter(logs(folder)), None)
    if log is None:
        return None
    frames, same = 0, True
    for part in (0.9, 0.5, 0.05):
        first = int(30.0 * part * secs)
        films = []
        for number in range(2):
            out = folder / f"film{first}-{number}"
            command = [chladni, "--quiet", "dance", "--show", log, "--frames", out, "--size", "160x90", "--piece", f"{first}..{first + 60}"]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"the show's log does not play: {done.stderr}")
            films.append([path.read_bytes() for path in sorted(out.glob("*.png"))])
        frames, same = frames + len(films[0]), same and films[0] == films[1]
    return {"actions": log.read_text().count("[[actions]]"), "frames": frames, "same": same}


def listed(name, found, wanted):
    """A row of the table: the verdicts that came out as `wanted`."""
    return f"| {name} | {'; '.join(words for words, good in found if good == wanted) or 'nothing'} |"


def main():
    chladni, folder, minutes, section = sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
    plan = PLANS[section]
    (folder / "chladni").mkdir()
    (folder / "chladni" / "settings.toml").write_text(f"[music]\nosc_port = {PORT}\n")
    report = evening(folder, chladni, 60.0 * minutes, plan)
    # Films take a while: all else is said before.
    print(json.dumps(report), flush=True)
    found = verdicts(report)
    for words, good in found:
        print("good:" if good else "BAD: ", words, file=sys.stderr, flush=True)
    log = replayed(folder, chladni, report["secs"])
    grown = lambda name: f"{report[name]['early']:,.0f} → {report[name]['late']:,.0f} (most {report[name]['most']:,.0f})"  # noqa: E731
    write_section(
        section,
        f"""## {plan.heading}

{machine()}; Xvfb, drawn by the processor unless a card is there, sound into a PulseAudio null sink. Early is the first tenth of the time after a warm-up of a sixth, late the last. Made by `{plan.command} {minutes:g}`.

| what | measured |
|---|---|
| time | {report["secs"] / 60:.1f} min |
| control messages, window resizes, sound devices lost, shapes opened, songs that followed by themselves | {report["messages"]}, {report["resized"]}, {report["unplugged"]}, {report["opened"]}, {report["followed"]} |
| resident memory at the same settings, song and shape, MB | {", ".join(f"{mb:,.0f}" for mb, _, _ in report["rests"])} |
| resident memory, MB | {grown("resident_mb")} |
| the same in each twelfth of the time | {", ".join(f"{mb:,.0f}" for mb in report["resident_mb"]["twelfths"])} |
| open files | {grown("open_files")} |
| threads | {grown("threads")} |
| frames | {report["frames"]:,} ({report["frames"] / report["secs"]:.1f} a second) |
| pause between two frames, median of each quarter of the time | {", ".join(f"{1e3 * s:.0f}" for s in report["median_quarters_secs"])} ms |
| longest | {report["longest_frame_secs"]:.3f} s |
| times the device had nothing to play; while it was there | {report["underruns"]}; {report["surprises"]} |
| actions in the show's log; frames filmed from it in three places, twice | {f"{log['actions']:,}; {log['frames']}, {'the same' if log['same'] else 'which differ'}" if log else "none was kept"} |
{listed("as it should be", found, True)}
{listed("not as it should be", found, False)}""",
    )
    if not all(good for _, good in found):
        sys.exit(1)


main()
