#!/usr/bin/env bash
# usage: bench/stage/measure.sh [SECONDS]     (CHLADNI=PATH takes another program than the built one)
# Opens the built program's music room on a virtual screen, with its sound going to a PulseAudio null
# sink, prints a JSON line and writes the section of BENCHMARKS.md: how the frames came, how the song's
# clock ran against the wall's, and the longest silence in what the sink's monitor recorded. Where a graphics
# device draws, in software or not, the same again by it.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
needs="parec sox" screen=1320x820
. bench/stage/hall.sh

# A song without a pause: noise that swells, longer than it is listened to.
sox -n -r 44100 -c 2 "$folder/song.wav" synth $((seconds + 30)) pinknoise tremolo 2 40 gain -6

# The window drawn by $1, its report and the sink's recording in $folder.
listen() {
  parec --device=null.monitor --raw --format=s16le --rate=48000 --channels=2 > "$folder/heard-$1.raw" &
  local recorder=$!
  pids+=("$recorder")
  "$chladni" open "$folder/song.wav" --draw "$1" --measure "$seconds" > "$folder/report-$1.json" 2> "$folder/errors" ||
    { cat "$folder/errors" >&2; rm -f "$folder/report-$1.json"; }
  kill "$recorder"
  wait "$recorder" 2> /dev/null || true
}
listen auto
[ -s "$folder/report-auto.json" ] || exit 1
listen gpu

# The longest run of silence between the first and the last sample that were heard.
python3 - "$folder" <<'PYTHON'
import array, json, os, sys
sys.path.append("bench")
from section import machine, write_section


def read(folder, draw):
    with open(f"{folder}/heard-{draw}.raw", "rb") as file:
        content = file.read()
    heard = array.array("h", content[: len(content) // 4 * 4])
    loud = [i // 2 for i in range(0, len(heard) - 1, 2) if heard[i] or heard[i + 1]]
    report = json.load(open(f"{folder}/report-{draw}.json"))
    report["heard_secs"] = (loud[-1] - loud[0]) / 48000 if loud else 0
    report["longest_silence_secs"] = max((b - a for a, b in zip(loud, loud[1:])), default=0) / 48000
    print(json.dumps(report))
    return report


folder = sys.argv[1]
draws = {"auto": "as it opens", "gpu": "`--draw gpu`"}
draws = {draw: name for draw, name in draws.items() if os.path.exists(f"{folder}/report-{draw}.json")}
reports = [read(folder, draw) for draw in draws]
stage = reports[0]["stage"]
rows = {
    "listened and drawn": lambda r: f"{r['secs']:.1f} s",
    f"frames of {stage['items']} shapes of {stage['vertices']:,} vertices": lambda r: f"{r['frames']} ({r['frames'] / r['secs']:.1f} a second)",
    "vertices drawn of each, about": lambda r: f"{r['stage']['drawn_vertices']:,}",
    "pause between two frames, median": lambda r: f"{r['median_frame_secs']:.3f} s",
    "longest": lambda r: f"{r['longest_frame_secs']:.3f} s",
    "the song went on by": lambda r: f"{r['song_secs']:.3f} s",
    "its clock against the wall's, largest difference": lambda r: f"{1e3 * r['largest_drift_secs']:.1f} ms",
    "times the device had nothing to play": lambda r: r["underruns"],
    "longest silence that the sink's monitor heard": lambda r: f"{1e3 * r['longest_silence_secs']:.2f} ms",
}
table = "\n".join(f"| {what} | {' | '.join(str(value(r)) for r in reports)} |" for what, value in rows.items())
write_section(
    "stage",
    f"""## The window with sound

{machine()}; 1320×820 on Xvfb, sound into a PulseAudio null sink. As it opens, a card draws where one is there, else the processor; a
device of software draws only where it is asked for. Made by `bench/stage/measure.sh`. Aim: 30 frames a second.

| what | {' | '.join(draws.values())} |
|---|{'---|' * len(draws)}
{table}""",
)
PYTHON
