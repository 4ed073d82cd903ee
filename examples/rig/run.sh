#!/usr/bin/env bash
# From a photograph's landmarks to a head that talks: run.sh NEW_DIR [SECONDS [PIXELS]]. About two minutes on two cores.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
out="$1" seconds="${2:-10}" pixels="${3:-320}"
mkdir -p "$out"

caricli reconstruct-from-landmarks "$here/../astronaut/landmarks.json" --out "$out/astronaut.obj"
caricli edit-semantic "$out/astronaut.npz" --label BigEye=1.5 --out "$out/eyes.obj"
caricli rig "$out/eyes.npz" --out "$out/rig.glb"
caricli inspect "$out/rig.glb"
"${PYTHON:-python}" "$here/make_weights.py" "$out/weights.json" "$seconds"
caricli animate "$out/rig.npz" "$out/weights.json" --out "$out/talk.glb"
caricli animate "$out/rig.npz" "$out/weights.json" --video "$out/preview.gif" --fps 15 --size "$pixels"
