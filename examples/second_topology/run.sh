#!/usr/bin/env bash
# Another mesh from OBJ files to a reconstructed face: run.sh NEW_DIR. About a minute on two cores.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
out="$1"
mkdir -p "$out"

"${PYTHON:-python}" "$here/make_meshes.py" "$out/scans" 40
caricli dataset import "$out/scans" "$out/dataset" --annotation "$out/scans/annotation.json"
caricli dataset show "$out/dataset" -o "$out/sheet.png" --faces 6 --size 128
caricli train intrinsic --data "$out/dataset" --out "$out/intrinsic.safetensors" --set dimension=24
caricli reconstruct-from-landmarks "$here/../astronaut/landmarks.json" --out "$out/astronaut.obj" \
    --model "$out/intrinsic.safetensors"
