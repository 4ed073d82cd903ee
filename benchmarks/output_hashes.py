"""Hashes of what every command writes on small inputs: the same before and after a change that should change nothing.

    python benchmarks/output_hashes.py hashes.json                       writes them
    python benchmarks/output_hashes.py hashes.json --against before.json  and says what differs

Wall-clock times are left out of JSON files; the states of trainings, which hold them, are not hashed. The hashes are
written even where a command fails, but then the run ends with exit 1 and names it: what never ran cannot differ.
"""

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
ASTRONAUT = ROOT / "examples" / "astronaut"
TINY = "--set epochs=2 --set points=32 --set width=16 --set hidden=16 --set latent=8"
SEER = "--set width=16 --set stem=8 --set depth=1 --set size=64 --set steps=150 --set batch=16 --set precision=float32"
DRAWER = "--set size=64 --set epochs=1 --set steps=4 --set batch=8 --set validate_every=1"
REPAINTER = "--set size=32 --set epochs=1 --set steps=4 --set batch=8 --set looks=1 --set validate_every=1"
TELLER = "--set size=64 --set epochs=1 --set steps=8 --set rounds=2 --set batch=8 --set painted=2 --set unmarked=0"
PEN = (
    "--set size=16 --set stride=1 --set epochs=1 --set steps=4 --set batch=8 --set validation=2 --set validate_every=1"
)
STYLER = "--set width=4 --set pictures=4 --set validation=2 --set epochs=1 --set steps=4 --set validate_every=1"

# Every line is run in turn in one folder; what it writes goes into a folder of its own, or beside the others.
COMMANDS = f"""
template export head.obj
template export open.obj --open-mouth
dataset build dataset --identities 4 --expressions 3 --levels 2 --seed 5 --workers 2 --albedo 2 --albedo-size 32
dataset build drawn --count 6 --identities 5 --workers 2
dataset show dataset -o show.png --faces 4 --size 48
dataset pictures drawn drawings --count 6 --size 96 --workers 2
dataset sketches drawn sketches --count 6 --workers 2
dataset textures drawn textures --count 5 --expressions 3 --size 48 --workers 2
dataset build many --count 60 --identities 12 --workers 2
dataset pictures many portraits --count 120 --size 96 --workers 2
train detector --pictures portraits --out seer {SEER} --set epochs=1 --set validate_every=1
detect astronaut.png --all --score 0 --detector seer/model.safetensors --out-dir seen
evaluate detector --pictures portraits --real pictures --detector seer/model.safetensors --out judged
sample --out-dir sampled --count 3 --seed 3 --subdivide 1
sample --out-dir plain --count 3 --seed 4
dataset import plain imported --annotation annotation.json
train pca --data dataset --out pca.safetensors --set dimension=5
train intrinsic --data dataset --out intrinsic.safetensors --set dimension=5
train kernel --data dataset --out kernel.safetensors --set dimension=5 --set components=8
train morphable --data dataset --out morphable.safetensors --set identity=3 --set expression=2 --set albedo=4
train bilinear --data dataset --out bilinear.safetensors --set identity=4
train sketch --data dataset --model pca.safetensors --out drawer {DRAWER}
train strokes --data dataset --out namer {DRAWER}
train style --out styler {STYLER}
train gesture --out pen {PEN}
evaluate gesture --network pen/model.safetensors --count 5 --out pen.json
train texture --data textures --out repainter {REPAINTER}
evaluate texture repainter/model.safetensors --data textures --count 4 --out repainted
train landmark-map --data dataset --out map.safetensors --set styles=1 --set views=2
train deformable --data dataset --out run {TINY} --set validate_every=1
train semantic --data big --out directions.npz --model pca --label BigNose --label Smile
evaluate shape pca.safetensors kernel --data dataset --out shape.json
evaluate ablation --data dataset --out ablation {TINY} --set array_hidden=8 --set code_steps=2 --set batch=4
evaluate sketch --data dataset --network drawer/model.safetensors --model pca.safetensors --count 4 --out drawn-again
evaluate portrait --data dataset --out portrait --count 1 --pictures pictures
evaluate blendshapes --data dataset --out expressions --count 1 --everyone
stylise astronaut.png --landmarks landmarks.json --out oil.png
stylise astronaut.png --landmarks landmarks.json --style watercolour --shape direction --out watercolour.png
stylise astronaut.png --landmarks landmarks.json --style ink --shape own --strength 2 --out ink.png
stylise astronaut.png --landmarks landmarks.json --style pencil --shape none --out pencil.png
stylise astronaut.png --landmarks landmarks.json --style flat --strength 0 --out flat.png
reconstruct-from-landmarks landmarks.json --image astronaut.png --out face.obj
reconstruct-from-landmarks landmarks.json --method latent --prior-weight 2 --out latent.obj --subdivide 1
reconstruct-from-landmarks landmarks.json --method latent --model deformable --out deformable.obj
reconstruct-from-sketch sketch.json --out drawn-face.obj
fit-morphable landmarks.json --image astronaut.png --out regular.obj
train coarse --data many --pictures portraits --detector seer/model.safetensors --out teller {TELLER}
fit-coarse landmarks.json --image astronaut.png --network teller/model.safetensors --out told.obj
fit-morphable landmarks.json --expression-only --identity regular.npz --out expression.obj
refine face.npz landmarks.json --image astronaut.png --out refined.obj
texture refined.npz astronaut.png --out textured --size 256
texture refined.npz astronaut.png --out flat --project-uv
encode face.obj --out encoded.npz
encode face.obj --out encoded-deformable.npz --model deformable
interpolate sampled/face-000.npz sampled/face-001.npz --steps 3 --out-dir between
map-landmarks landmarks.json --to normal --out normal.json
map-landmarks landmarks.json --to caricature --style-seed 3 --out caricature.json
edit-handle sampled/face-000.npz --handle nose_tip=0,0,0.01 --pin chin --symmetric --out pulled.obj --baseline arap
edit-handle sampled/face-001.npz --handle l30=0,0,0.008 --norm l1 --no-intersections --steps 2 --out strip.obj
refine-gesture sampled/face-000.npz --script strokes.json --out refined-nose.obj
edit-semantic sampled/face-000.npz --label BigNose=2 --keep BigEar --steps 3 --out nose.obj
caricaturize sampled/face-000.npz --strength 1.5 --out caricaturized.obj
caricaturize landmarks.json --from-landmarks --image astronaut.png --mode own --out own.obj
studio --replay session.json --out replayed.obj
rig textured/face.npz --out rig.glb --usd
portrait pictures/astronaut.png --landmarks landmarks.json --size 256 --parts skin,eyes --out-dir heads
rig head.obj --out sparse.glb --sparse --subdivide 1 --parts skin
blendshapes textured/face.npz --expressions moods.yaml --out blendshapes.npz
blendshapes landmarks.json --expressions moods.yaml --method initial --reconstruct latent --out initial.npz
retarget blendshapes.npz plain/face-000.obj --neutral head.obj --out retargeted.obj
retarget blendshapes.npz landmarks.json --out photographed.obj --animation driven.glb
animate rig.npz weights.json --out talk.glb --frames frames --format obj --smooth 1
animate rig.npz weights.json --video talk.gif --size 64
render face.npz head.obj -o sheet.png --size 96
sketch face.npz --out sketch.svg
sketch face.npz --out aside.png --view 40,0
render face.npz -o overlay.png --image astronaut.png
render face.npz -o turn.png --views turntable --frames 3 --size 64
""".strip().splitlines()  # fmt: skip
# Commands that no line above runs, and why.
LEFT_OUT = {"inspect": "prints what is in a file and writes none"}

MOODS = "neutral: {}\nsmile: {mouthSmile: 0.7}\nopen: {jawOpen: 0.8}\nblink: {eyeBlink: 1.0}\n"
WEIGHTS = {"schema": "caricli.weights/1", "fps": 10, "names": ["jawOpen", "eyeBlinkLeft"], "head": [[0, 0, 0]] * 3,
           "weights": [[0.0, 0.0], [0.5, 0.3], [0.9, 1.0]]}  # fmt: skip
SESSION = {"schema": "caricli.session/1", "start": None, "operations": [
    {"name": "draw", "parameters": {"points": [[106, 260], [256, 450], [406, 260], [256, 70], [106, 260]]}},
    {"name": "semantic", "parameters": {"strengths": {"BigNose": 1.5}}},
    {"name": "expression", "parameters": {"weights": {"jawOpen": 0.5}}},
]}  # fmt: skip
SKETCH = {"schema": "caricli.sketch/1", "canvas": {"width": 256, "height": 256}, "strokes": [
    {"kind": "silhouette", "curve": "silhouette", "points": [[64, 120], [70, 190], [128, 236], [186, 190], [192, 120]]},
    {"kind": "feature", "curve": "brow_right", "points": [[82, 104], [96, 96], [112, 102]]},
    {"kind": "feature", "curve": "brow_left", "points": [[144, 102], [160, 96], [174, 104]]},
    {"kind": "feature", "curve": "nose", "points": [[110, 160], [128, 172], [146, 160]]},
    {"kind": "feature", "curve": "mouth_inner_upper", "points": [[100, 196], [128, 190], [156, 196]]},
]}  # fmt: skip
FRONT = {"scale": 1000.0, "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "translation": [0, 0]}
STROKES = {"schema": "caricli.session/1", "start": None, "operations": [
    {"name": "brush", "parameters": {"points": [[0, 0]], "radius": 15, "camera": FRONT}},
    {"name": "line", "parameters": {"points": [[0, 0], [5, 8]], "camera": FRONT, "symmetric": True}},
    {"name": "bulge", "parameters": {"level": 2}},
]}  # fmt: skip
_UNHASHED = {".pt"}
_TIMES = {"seconds"}


def main():
    """Run all commands and write or compare the hashes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--against", type=Path, help="hashes of before")
    parser.add_argument("--package", type=Path, default=ROOT, help="the checkout whose commands are run")
    parser.add_argument("--keep", type=Path, help="a new folder for what the commands write")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(exist_ok=True)
        package = options.package.resolve()
        failed = run_all(folder, package)
        hashes = hash_all(folder, package)
    options.out.write_text(json.dumps(hashes, indent=1) + "\n")
    print(f"{len(COMMANDS)} commands, {len(failed)} failed", *failed, sep="\n  ")
    different = []
    if options.against:
        before = json.loads(options.against.read_text())
        different = [name for name in sorted({*before, *hashes}) if before.get(name) != hashes.get(name)]
        print(f"{len(hashes)} files, {len(different)} different", *different, sep="\n  ")
    sys.exit(bool(different or failed))


def run_all(folder, package):
    """Run all commands in a folder. Returns the lines of those that failed."""
    failed = []
    environment = os.environ | {"PYTHONPATH": str(package), "OMP_NUM_THREADS": "1"}
    prepare(folder, environment)
    for line in COMMANDS:
        start = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-m", "caricli", *line.split()],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            failed.append(line)
        print(f"{done.returncode} {time.monotonic() - start:5.1f} s  {line}", done.stderr[-300:], flush=True)
    return failed


def hash_all(folder, package):
    """Hashes of all files of a folder by name."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix not in _UNHASHED)
    return {path.relative_to(folder).as_posix(): digest(path, package) for path in files}


def prepare(folder, environment):
    """Lay the inputs into the folder that no command makes."""
    subprocess.run([sys.executable, str(ASTRONAUT / "fetch_image.py"), str(folder / "astronaut.png")], check=True)
    shutil.copy(ASTRONAUT / "landmarks.json", folder)
    shutil.copy(ROOT / "caricli" / "assets" / "head_annotation.json", folder / "annotation.json")
    (folder / "pictures").mkdir()
    shutil.copy(folder / "astronaut.png", folder / "pictures")
    shutil.copy(folder / "landmarks.json", folder / "pictures" / "astronaut.json")
    (folder / "moods.yaml").write_text(MOODS)
    (folder / "weights.json").write_text(json.dumps(WEIGHTS))
    (folder / "sketch.json").write_text(json.dumps(SKETCH))
    (folder / "strokes.json").write_text(json.dumps(STROKES))
    (folder / "session.json").write_text(json.dumps(SESSION))
    sizes = "dataset build big --count 90 --identities 30 --workers 2".split()
    subprocess.run([sys.executable, "-m", "caricli", *sizes], cwd=folder, env=environment, check=True)


def digest(path, package):
    """SHA-256 of a file, of JSON without its times and the place of the package, whose bundled files are inputs."""
    data = path.read_bytes()
    if path.suffix in (".json", ".jsonl"):
        data = data.replace(str(package).encode(), b"$caricli")
        lines = data.splitlines() if path.suffix == ".jsonl" else [data]
        data = json.dumps([without_times(json.loads(line)) for line in lines]).encode()
    elif path.name == "ablation.md":
        data = b"\n".join(line.rsplit(b"|", 2)[0] for line in data.splitlines())
    return hashlib.sha256(data).hexdigest()


def without_times(value):
    """A JSON value without what a clock said."""
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in _TIMES}
    return [without_times(item) for item in value] if isinstance(value, list) else value


if __name__ == "__main__":
    main()
