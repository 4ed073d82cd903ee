"""What is said of every kind of thing that files hold."""

from collections import Counter
from dataclasses import replace
from functools import singledispatch
from typing import Any

import numpy as np

from caricli.data.dataset import SPLITS, Dataset
from caricli.data.picture_set import PictureSet
from caricli.data.sketch_set import SketchSet
from caricli.data.summarise_pictures import summarise_pictures
from caricli.data.summarise_textures import summarise_textures
from caricli.data.texture_set import TextureSet
from caricli.errors import shown
from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.io.parsing import SCHEMA as PARSING_SCHEMA
from caricli.methods.inspect.describe_networks import describe_network
from caricli.methods.inspect.inspection import Acquaintances, Animated, FolderPart, Inspection, MeshWords
from caricli.methods.rig.check_rig import RigCheck, check_rig
from caricli.models.detector.model import Detector
from caricli.models.landmark_map.model import LandmarkMap
from caricli.models.network_model import NetworkModel
from caricli.structures import Cues, Directions, Face, Landmarks, Material, Mesh, Rig, Session, Sketch, Track
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.landmarks import PARTS, SCHEMES
from caricli.structures.materials import HEAD_PARTS
from caricli.structures.pictures import PICTURED

_NAMED = 12
"""Names that a line lists."""

_BATCH = 32
"""Meshes whose triangles are looked at together."""


@singledispatch
def describe(value: Any, around: Acquaintances) -> Inspection:
    """What is said of a structure; of any other value, it is a shape model."""
    words = MeshWords.of(value.template, around)
    dimension = len(value.prior.mean)
    bundled = around.models.get(value.model_id)
    lines = ["one of those that come with caricli"] if bundled else [f"id {value.model_id[:12]}"]
    people = None if value.seen is None else len(value.seen.train)
    lines.append("no word of whom it was trained with" if people is None else f"trained with {people} people")
    values = {"model_kind": value.kind, "dimension": dimension, "model_id": value.model_id, "bundled": bool(bundled)}
    values |= {} if people is None else {"people": people}
    summary = f"{value.kind}, {dimension} dimensions, {words.counts}"
    problems = tuple(words.check.problems)
    return Inspection("shape model", summary, (*lines, *words.lines), values | words.values, problems)


@describe.register
def _(value: Mesh, around: Acquaintances) -> Inspection:
    words = MeshWords.of(value, around)
    summary = f"{words.counts}, {words.height}"
    return Inspection("mesh", summary, tuple(words.lines), words.values, tuple(words.check.problems))


@describe.register
def _(value: Face, around: Acquaintances) -> Inspection:
    words = MeshWords.of(value.mesh, around)
    lines = list(words.lines)
    values: dict[str, Any] = dict(words.values)
    if value.camera is not None:
        lines.append(f"a camera of {value.camera.scale:.4g} pixels a metre")
        values["camera_scale"] = value.camera.scale
    if value.landmarks is not None:
        lines.append(f"{len(value.landmarks)} landmarks")
        values["landmarks"] = len(value.landmarks)
    if value.latent is not None:
        of = "an unknown model" if value.model_id is None else around.model_name(value.model_id)
        residual = "" if value.residual is None else ", and a residual"
        lines.append(f"a latent of {len(value.latent)} numbers of {of}{residual}")
        values |= {"latent": len(value.latent), "model_id": value.model_id, "residual": value.residual is not None}
    lines.append(f"made of {', '.join(_made_of(value))}")
    values["parts"] = _made_of(value)
    summary = f"{words.counts}, {words.height}"
    return Inspection("face", summary, tuple(lines), values, tuple(words.check.problems))


@describe.register
def _(value: Rig, around: Acquaintances) -> Inspection:
    words = MeshWords.of_skin(value, around)
    check = check_rig(value)
    extras = [f"a picture of {name}" for name in PICTURED.values() if getattr(value.pictures, name) is not None]
    more = {"normal_deltas": "normal_deltas", "depiction": "its place in its picture"}
    more["changes"] = "what expressions do to the picture of skin"
    extras += [said for name, said in more.items() if getattr(value, name) is not None]
    moods = [mood.name for mood in value.moods]
    lines = [f"made of {', '.join(_made_of(value))}"]
    lines += [f"with {', '.join(extras)}"] if extras else []
    lines += [f"moods of the skin: {_listed(moods)}"] if moods else []
    shapes = [vars(shape) for shape in check.shapes]
    values = {
        "shapes": shapes,
        "parts": _made_of(value),
        "moods": moods,
        "arkit": {key: getattr(check, key) for key in ("exact", "near", "unknown", "missing")},
    }
    summary = f"{words.counts}, {len(value.names)} shapes, {words.height}"
    lines = [*words.lines, *lines, *(_rig_lines(check) if value.names else ())]
    return Inspection("rig", summary, tuple(lines), values | words.values, tuple(words.check.problems))


@describe.register
def _(value: Animated, around: Acquaintances) -> Inspection:
    still = describe(value.still, around)
    lines = [
        f"animation {shown(clip.name, 60)!r}: {clip.length:.3g} s, {clip.frames} frames"
        for clip in value.clips[:_NAMED]
    ]
    lines += [f"and {len(value.clips) - _NAMED} more animations"] if len(value.clips) > _NAMED else []
    values = still.values | {"animations": [vars(clip) for clip in value.clips]}
    return replace(still, lines=(*lines, *still.lines), values=values)


def _made_of(value: Face | Rig) -> list[str]:
    """Names of the parts of a head."""
    materials = [Material.SKIN] if value.materials is None else value.materials
    hair = [Material.HAIR] if isinstance(value, Face) and value.hair is not None else []
    return [name for name, own in HEAD_PARTS.items() if np.isin(own, [*materials, *hair]).any()]


def _rig_lines(check: RigCheck) -> list[str]:
    """What of ARKit is there, and a table of the shapes."""
    lines = [f"ARKit: {len(check.exact)} of {len(ARKIT_NAMES)} names, {len(check.missing)} missing"]
    for name, arkit in check.near.items():
        whole = f"a part of {arkit}, which is there" if arkit in check.exact else f"ARKit spells it {arkit}"
        lines.append(f"{name}: {whole}")
    lines += [f"{name}: no ARKit name" for name in check.unknown]
    lines += [f"missing: {', '.join(check.missing)}"] if check.missing else []
    width = max(len(shape.name) for shape in check.shapes)
    lines.append(f"{'shape':{width}}  largest mm   moved  flipped %")
    for shape in check.shapes:
        flipped = "     -" if shape.flipped is None else f"{100 * shape.flipped:6.3f}"
        lines.append(f"{shape.name:{width}}  {1000 * shape.largest:10.2f}  {shape.moved:6}     {flipped}")
    return lines


@describe.register
def _(value: Landmarks, around: Acquaintances) -> Inspection:
    given = value.known
    size = value.image_size
    missing = {part: int((~given[list(ids)]).sum()) for part, ids in PARTS.items() if max(ids) < len(given)}
    missing = {part: count for part, count in missing.items() if count}
    lines = [f"not known: {', '.join(f'{count} of {part}' for part, count in missing.items())}"] if missing else []
    lines.append("no size of the picture" if size is None else f"a picture of {size[0]} x {size[1]} pixels")
    values = {"scheme": SCHEMES[len(given)], "points": len(given), "missing": missing, "image_size": size}
    summary = f"{SCHEMES[len(given)]}, {given.sum()} of {len(given)} points known, {value.diagonal:.4g} pixels across"
    return Inspection("landmarks", summary, tuple(lines), values | {"diagonal": value.diagonal})


@describe.register
def _(value: Sketch, around: Acquaintances) -> Inspection:
    kinds = Counter(str(stroke.kind) for stroke in value.strokes)
    curves = [stroke.curve for stroke in value.strokes if stroke.curve is not None]
    points = sum(len(stroke.points) for stroke in value.strokes)
    length = sum(stroke.length for stroke in value.strokes)
    width, height = value.size
    lines = [f"strokes: {', '.join(f'{count} {kind}' for kind, count in kinds.items())}"] if kinds else []
    lines += [f"curves: {_listed(curves)}"] if curves else []
    summary = f"{len(value.strokes)} strokes of {length:.4g} pixels together, {width} x {height} pixels"
    values = {"strokes": len(value.strokes), "points": points, "kinds": dict(kinds), "curves": curves}
    return Inspection("sketch", summary, tuple(lines), values | {"length": length, "size": [width, height]})


@describe.register
def _(value: Session, around: Acquaintances) -> Inspection:
    counts = Counter(operation.name for operation in value.operations)
    start = None if value.start is None else value.start.file
    lines = ["begins with an empty canvas" if start is None else f"begins with {shown(start)}"]
    lines += [", ".join(f"{count} {name}" for name, count in counts.items())] if counts else []
    values = {"operations": len(value.operations), "names": dict(counts), "start": start}
    return Inspection("session", f"{len(value.operations)} operations", tuple(lines), values)


@describe.register
def _(value: Track, around: Acquaintances) -> Inspection:
    frames = len(value.times)
    length = float(value.times[-1])
    still = [name for name, column in zip(value.names, value.weights.T, strict=True) if not column.any()]
    arkit = sum(name in ARKIT_NAMES for name in value.names)
    lines = [
        f"ARKit: {arkit} of {len(ARKIT_NAMES)} names"
        + (f", others: {_listed(_others(value))}" if _others(value) else ""),
        f"weights from {value.weights.min():.3g} to {value.weights.max():.3g}",
        "the head turns" if value.head is not None else "the head keeps still",
    ]
    lines += [f"always 0: {_listed(still)}"] if still else []
    values = {
        "frames": frames,
        "length": length,
        "names": value.names,
        "arkit": arkit,
        "head": value.head is not None,
    }
    return Inspection("weights", f"{frames} frames, {length:.3g} s, {len(value.names)} names", tuple(lines), values)


@describe.register
def _(value: Cues, around: Acquaintances) -> Inspection:
    lengths = np.diff(np.append(value.starts, value.end))
    held = {name: float(lengths[[own == name for own in value.names]].sum()) for name in sorted(set(value.names))}
    lines = [f"{name}: {value.names.count(name)} times, {length:.3g} s" for name, length in held.items()]
    values = {"cues": len(value.names), "length": value.end, "names": held}
    return Inspection("speech", f"{len(value.names)} mouth cues, {value.end:.3g} s", tuple(lines), values)


def _others(track: Track) -> list[str]:
    return [name for name in track.names if name not in ARKIT_NAMES]


@describe.register
def _(value: Directions, around: Acquaintances) -> Inspection:
    lines = [f"{name}: area under the curve {auc:.3f}" for name, auc in zip(value.names, value.auc, strict=True)]
    dimension = value.normals.shape[1]
    values = {"labels": value.figures, "dimension": dimension, "model_id": value.model_id, "count": int(value.count)}
    summary = f"{len(value.names)} labels of {dimension} numbers, of {around.model_name(value.model_id)}"
    return Inspection("directions", summary, tuple(lines), values)


@describe.register
def _(value: LandmarkMap, around: Acquaintances) -> Inspection:
    count = len(value.styles)
    summary = f"from caricatures to normal faces, and back in styles of {count} component{'s' * (count != 1)}"
    return Inspection("landmark map", summary, (), {"styles": count})


@describe.register
def _(value: Detector, around: Acquaintances) -> Inspection:
    summary = f"{value.weights.count / 1e6:.1f} million weights, for faces in windows of {value.size} pixels"
    return Inspection(
        "detector", summary, (), {"weights": value.weights.count, "size": value.size, "model_id": value.model_id}
    )


@describe.register
def _(value: NetworkModel, around: Acquaintances) -> Inspection:
    return describe_network(value, around)


@describe.register
def _(value: Dataset, around: Acquaintances) -> Inspection:
    words = MeshWords.of(value.template, around)
    counts = {split: int(value.rows(split).sum()) for split in SPLITS}
    people = len(np.unique(value.identity))
    share = _flipped_share(value)
    lines = [
        *words.lines,
        "split by identity: " + ", ".join(f"{split} {count}" for split, count in counts.items()),
        f"labels: {_listed(value.attributes)}" if len(value.attributes) else "no labels",
        f"flipped triangles: mean {100 * share.mean():.3f} %, worst mesh {100 * share.max():.3f} %",
    ]
    values = {"meshes": len(value.vertices), "people": people, "splits": counts, "labels": list(value.attributes)}
    values |= {"flipped_mean": float(share.mean()), "flipped_worst": float(share.max())}
    broken = int((~np.isfinite(value.vertices)).any((1, 2)).sum())
    problems = [*words.check.problems, *([f"{broken} meshes with coordinates that are not finite"] if broken else [])]
    summary = f"{len(value.vertices)} meshes of {people} people, {words.counts}"
    return Inspection("dataset", summary, tuple(lines), values | words.values, tuple(problems))


@describe.register
def _(value: PictureSet, around: Acquaintances) -> Inspection:
    faces = len(value.truth["picture"])
    values = {"pictures": value.count, "faces": faces, "people": len(np.unique(value.truth["person"]))}
    lines = (*map(shown, summarise_pictures(value)[1:]), _topology(value.manifest, around))
    summary = f"{value.count} pictures, {faces} faces of {values['people']} people"
    return Inspection("pictures", summary, lines, values, _unlike(value))


@describe.register
def _(value: SketchSet, around: Acquaintances) -> Inspection:
    count = value.manifest["count"]
    people = len(np.unique(value.truth["person"]))
    splits = {split: len(value.rows_of(split)) for split in SPLITS}
    lines = (
        f"splits: {', '.join(f'{number} {split}' for split, number in splits.items())}",
        f"curves: {shown(_listed(value.manifest['curves']), 400)}",
        _topology(value.manifest, around),
    )
    values = {"sketches": count, "people": people, "splits": splits, "side": value.side}
    summary = f"{count} sketches of {people} people, {value.side} x {value.side} pixels"
    return Inspection("sketches", summary, lines, values, _unlike(value))


@describe.register
def _(value: TextureSet, around: Acquaintances) -> Inspection:
    lines = (*summarise_textures(value), _topology(value.manifest, around))
    values = {"people": value.count, "expressions": value.shown, "size": value.size}
    summary = f"{value.count} people with {value.shown} expressions, {value.size} x {value.size} texels"
    return Inspection("textures", summary, lines, values)


@describe.register
def _(value: FolderPart, around: Acquaintances) -> Inspection:
    names = shown(_listed(value.arrays), 400)
    values = {"folder": value.folder, value.counted: value.count, "arrays": list(value.arrays)}
    return Inspection(f"a part of {value.folder}", f"{value.count} {value.counted}", (f"holds: {names}",), values)


def _topology(manifest: dict[str, Any], around: Acquaintances) -> str:
    same = manifest.get("topology_id") == around.head.topology_id
    return f"topology: {'that of the bundled models' if same else 'not known'}"


def _unlike(value: PictureSet | SketchSet) -> tuple[str, ...]:
    """The problem that pictures are not there, or not as they were written, if they are not."""
    if missing := value.missing:
        return (f"{missing} pictures missing",)
    return ("pictures changed since they were written",) if value.changed else ()


def _flipped_share(data: Dataset) -> np.ndarray:
    """(N,) share of triangles of every mesh that are turned over against the template."""
    gradients = DeformationGradients(data.template.vertices, data.template.faces)
    starts = range(0, len(data.vertices), _BATCH)
    return np.concatenate([flipped_triangles(data.vertices[k : k + _BATCH], gradients).mean(-1) for k in starts])


@describe.register
def _(value: dict, around: Acquaintances) -> Inspection:
    """A report of ours, the legend of a label map, or weights of actions by expression."""
    inputs = value.get("inputs")
    source = [f"made from: {_listed(list(inputs))}"] if inputs and isinstance(inputs, dict) else []
    if value.get("schema") == PARSING_SCHEMA:
        faces = value.get("faces")
        count = len(faces) if isinstance(faces, list) else None
        lines = [*source, shown(_listed(list(value["labels"])), 400), *([] if count is None else [f"faces: {count}"])]
        values = {"labels": value["labels"], "faces": count}
        return Inspection("legend", f"{len(value['labels'])} labels of a label map", tuple(lines), values)
    if "command" not in value:
        actions = sorted({action for weights in value.values() for action in weights})
        lines = [_listed(list(value)), f"of {len(actions)} actions: {_listed(actions)}"]
        return Inspection("expressions", f"{len(value)} of them", tuple(lines), {"expressions": value})
    about = ("command", "version", "inputs", "seed")
    lines = [*source, f"holds: {_listed([key for key in value if key not in about])}"]
    values = {key: value[key] for key in about if key in value} | {"keys": [key for key in value if key not in about]}
    return Inspection("report", f"caricli {value['command']}, version {value.get('version')}", tuple(lines), values)


@describe.register
def _(value: np.ndarray, around: Acquaintances) -> Inspection:
    """A picture."""
    height, width = value.shape[:2]
    return Inspection("picture", f"{width} x {height} pixels", (), {"width": width, "height": height})


def _listed(names: Any) -> str:
    names = [name for name, _ in Counter(names).most_common()]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
