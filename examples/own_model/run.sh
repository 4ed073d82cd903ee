#!/usr/bin/env bash
# From nothing to a face in a model of one's own: run.sh NEW_DIR. Small sizes, about a minute on two cores.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
out="$1"
mkdir -p "$out"

caricli template export "$out/head.obj"
caricli dataset build "$out/dataset" --count 24 --identities 8 --seed 1
caricli dataset show "$out/dataset" -o "$out/sheet.png" --faces 6 --size 128
caricli train pca --data "$out/dataset" --out "$out/pca.safetensors" --config "$here/../../configs/pca/tiny.yaml"
caricli train intrinsic --data "$out/dataset" --out "$out/intrinsic.safetensors" --set dimension=12
caricli evaluate shape "$out/pca.safetensors" "$out/intrinsic.safetensors" --data "$out/dataset"
caricli reconstruct-from-landmarks "$here/../astronaut/landmarks.json" --out "$out/astronaut.obj" \
    --model "$out/intrinsic.safetensors"
caricli reconstruct-from-landmarks "$here/../astronaut/landmarks.json" --out "$out/latent.obj" \
    --method latent --model "$out/pca.safetensors"
caricli render "$out/astronaut.npz" "$out/latent.npz" -o "$out/both.png" --views front,profile --size 128
