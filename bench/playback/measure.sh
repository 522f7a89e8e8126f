#!/usr/bin/env bash
# usage: bench/playback/measure.sh [SECONDS]
# Plays our tune through a PulseAudio null sink while every core is busy, records the sink's monitor
# and prints what came out against what was decoded, as one JSON line.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
cargo build --release --quiet -p chladni-sound --examples
examples=${CARGO_TARGET_DIR:-target}/release/examples
folder=$(mktemp -d)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; rm -r "$folder"' EXIT
"$examples/write_tune" "$folder/tune.wav"
printf '</usr/share/alsa/alsa.conf>\npcm.!default { type pulse }\nctl.!default { type pulse }\n' > "$folder/alsa.conf"
export ALSA_CONFIG_PATH=$folder/alsa.conf PULSE_RUNTIME_PATH=$folder
pulseaudio -n --daemonize=no --exit-idle-time=-1 --use-pid-file=no --log-target=null \
  -L "module-null-sink sink_name=null norewinds=1 rate=48000" \
  -L "module-native-protocol-unix auth-anonymous=1 socket=$folder/socket" &
pids+=($!)
export PULSE_SERVER=unix:$folder/socket
until pactl info > /dev/null 2>&1; do sleep 0.1; done
for _ in $(seq "$(nproc)"); do
  sh -c 'while :; do :; done' &
  pids+=($!)
done
"$examples/playback" check "$folder/tune.wav" "$seconds"
