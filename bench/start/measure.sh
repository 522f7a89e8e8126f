#!/usr/bin/env bash
# usage: bench/start/measure.sh MESH [TIMES]
# How long `chladni open MESH` takes until the shape is on screen, with its harmonics in the cache: TIMES
# (default 5) runs as JSON, after one that warms up. Opens its windows on a virtual screen (Xvfb) unless
# DISPLAY names another. CHLADNI names the program.
set -euo pipefail
mesh=$(realpath "$1")
times=${2:-5}
cd "$(dirname "$0")/../.."
chladni=${CHLADNI:-${CARGO_TARGET_DIR:-target}/release/chladni}
[ -n "${CHLADNI:-}" ] || cargo build --release --quiet -p chladni-program
screen() { if [ -n "${DISPLAY:-}" ]; then "$@"; else xvfb-run -a -s '-screen 0 1440x900x24' "$@"; fi; }
"$chladni" --quiet basis "$mesh" -k 512 >/dev/null
screen "$chladni" open "$mesh" --until-picture >/dev/null 2>&1
for _ in $(seq "$times"); do
  screen "$chladni" open "$mesh" --until-picture 2>/dev/null
done
