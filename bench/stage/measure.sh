#!/usr/bin/env bash
# usage: bench/stage/measure.sh [SECONDS]     (CHLADNI=PATH takes another program than the built one)
# Opens the built program's music room on a virtual screen, with its sound going to a PulseAudio null
# sink, prints one JSON line and writes the section of BENCHMARKS.md: how the frames came, how the song's
# clock ran against the wall's, and the longest silence in what the sink's monitor recorded.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
needs=parec screen=1320x820
. bench/stage/hall.sh

# A song without a pause: noise that swells, longer than it is listened to.
sox -n -r 44100 -c 2 "$folder/song.wav" synth $((seconds + 30)) pinknoise tremolo 2 40 gain -6

parec --device=null.monitor --raw --format=s16le --rate=48000 --channels=2 > "$folder/heard.raw" &
pids+=($!)
"$chladni" open "$folder/song.wav" --measure "$seconds" > "$folder/report.json" 2> "$folder/errors" || { cat "$folder/errors" >&2; exit 1; }
kill "${pids[2]}"
wait "${pids[2]}" 2> /dev/null || true

# The longest run of silence between the first and the last sample that were heard.
python3 - "$folder" <<'PYTHON'
import array, json, sys
sys.path.append("bench")
from section import machine, write_section
folder = sys.argv[1]
with open(f"{folder}/heard.raw", "rb") as file:
    heard = array.array("h", file.read()[: -4 or None])
loud = [i // 2 for i in range(0, len(heard) - 1, 2) if heard[i] or heard[i + 1]]
report = json.load(open(f"{folder}/report.json"))
report["heard_secs"] = (loud[-1] - loud[0]) / 48000 if loud else 0
report["longest_silence_secs"] = max((b - a for a, b in zip(loud, loud[1:])), default=0) / 48000
print(json.dumps(report))

stage = report["stage"]
rows = [
    ("listened and drawn", f"{report['secs']:.1f} s"),
    (
        f"frames of {stage['items']} shapes of {stage['vertices']:,} vertices, about {stage['drawn_vertices']:,} of them drawn",
        f"{report['frames']} ({report['frames'] / report['secs']:.1f} a second)",
    ),
    ("pause between two frames, median", f"{report['median_frame_secs']:.3f} s"),
    ("longest", f"{report['longest_frame_secs']:.3f} s"),
    ("the song went on by", f"{report['song_secs']:.3f} s"),
    ("its clock against the wall's, largest difference", f"{1e3 * report['largest_drift_secs']:.1f} ms"),
    ("times the device had nothing to play", report["underruns"]),
    ("longest silence that the sink's monitor heard", f"{1e3 * report['longest_silence_secs']:.2f} ms"),
]
table = "\n".join(f"| {what} | {value} |" for what, value in rows)
write_section(
    "stage",
    f"""## The window with sound

{machine()}; 1320×820 on Xvfb, drawn by the processor unless a card is there, sound into a PulseAudio null sink. Made by `bench/stage/measure.sh`.

| what | measured |
|---|---|
{table}""",
)
PYTHON
