#!/usr/bin/env bash
# From mouth cues to a head that says them: run.sh NEW_DIR [PIXELS]. Half a minute on two cores.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
out="$1" pixels="${2:-320}"
mkdir -p "$out"

caricli template export "$out/head.obj"
caricli rig "$out/head.obj" --out "$out/rig.glb"
caricli inspect "$here/cues.json"
caricli animate "$out/rig.npz" "$here/cues.json" --out "$out/speech.glb" --fps 60
caricli animate "$out/rig.npz" "$here/cues.json" --video "$out/speech.gif" --fps 25 --size "$pixels"
