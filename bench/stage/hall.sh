# Sourced by measurements of the window on a machine without a screen: finds or builds the program as $chladni, and
# opens a virtual screen and a null sink, in a $folder that goes at the end. $needs names the programs it takes.
# shellcheck shell=bash
for program in Xvfb pulseaudio pactl $needs; do
  command -v "$program" > /dev/null || { echo "$program is missing" >&2; exit 1; }
done
[ -n "${CHLADNI:-}" ] || cargo build --release --quiet -p chladni-program
chladni=${CHLADNI:-${CARGO_TARGET_DIR:-target}/release/chladni}
folder=$(mktemp -d)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait 2>/dev/null; rm -rf "$folder"' EXIT

unset WAYLAND_DISPLAY
. bench/null_sink.sh
Xvfb -noreset -displayfd 3 -screen 0 "${screen}x24" 3> "$folder/display" 2> /dev/null &
pids+=($!)
until [ -s "$folder/display" ]; do sleep 0.1; done
DISPLAY=:$(cat "$folder/display")
export DISPLAY
