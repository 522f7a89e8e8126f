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
. bench/null_sink.sh
for _ in $(seq "$(nproc)"); do
  sh -c 'while :; do :; done' &
  pids+=($!)
done
"$examples/playback" check "$folder/tune.wav" "$seconds"
