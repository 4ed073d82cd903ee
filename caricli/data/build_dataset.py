"""The open caricature dataset: random people, expressions and exaggerations of the head."""

import contextlib
import functools
import multiprocessing
import os
import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.data.albedo import TexturePainter, random_look
from caricli.data.attributes import binary_labels, measure_attributes
from caricli.data.dataset import ALBEDO_FILE, SHARD_SIZE, split_identities, write_dataset
from caricli.data.exaggerate_parts import exaggerate_parts
from caricli.data.expressions import expand_sides
from caricli.data.identities import random_identity
from caricli.data.move_parts import NAMES, random_hand, random_part_changes
from caricli.errors import CaricliError, InputError
from caricli.geometry.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.similarity import similarity
from caricli.geometry.untangle import untangle
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.io.npz import write_npz
from caricli.io.provenance import sha256_file
from caricli.limits import MAX_NPZ_BYTES
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.template.annotation import DELICATE
from caricli.template.head import load_head

KINDS = ("regular", "curvature", "parts", "curvature and parts")
KIND_SHARES = (0.15, 0.15, 0.35, 0.35)
PART_STRENGTH = (0.75, 1.6)
EXPONENTS = (0.0, 0.1, 0.2, 0.3)
MAX_FLIPPED = 0.0008
PRIOR_SHAPES, PRIOR_DIMENSION = 360, 128
TRIES = 30
_IDENTITY, _DRAW, _PRIOR, _SPLIT, _ALBEDO = range(5)
_STRANGERS = 1_000_000


@dataclass(frozen=True)
class BuildSettings:
    """What to build: without count the full grid, with it that many random draws."""

    count: int | None = None
    identities: int = 150
    expressions: int = 25
    levels: int = 4
    seed: int = 0

    def __post_init__(self):
        """Refuse sizes that cannot be built."""
        limits = {"identities": (1, 100_000), "expressions": (1, 25), "levels": (1, len(EXPONENTS))}
        for name, (low, high) in limits.items():
            if not low <= getattr(self, name) <= high:
                raise InputError(f"{name} must be from {low} to {high}, found {getattr(self, name)}")
        if self.count is not None and self.count < 1:
            raise InputError(f"count must be at least 1, found {self.count}")


def build_dataset(folder, settings, workers=None, progress=lambda done, total: None, albedos=0, albedo_size=256):
    """Build a dataset into an empty folder (sketch paper section 4.1, with exaggeration by parts beside curvature).

    The same settings give the same bytes, whatever the number of workers.

    folder: Path. settings: BuildSettings. workers: processes; None for one per usable core. progress: called with the
    number of finished meshes and their total. albedos: how many random colours of the head to draw beside the meshes,
    as pictures of albedo_size texels a side.
    Returns the manifest's summary: meshes, flipped triangles. Raises InputError for more albedos than a file can hold.
    """
    if 3 * albedos * albedo_size**2 > 0.9 * MAX_NPZ_BYTES:
        raise InputError(f"{albedos} albedos of {albedo_size} texels a side are more than one file can hold")
    head = load_head()
    template = head.template()
    expressions = list(_expression_table(head))[: settings.expressions]
    jobs = _jobs(settings)
    total, rows = sum(len(job) for job in jobs), []
    flipped = []

    def shards():
        pending = []
        prior = None
        if settings.count is not None:
            with _worker_map(workers, settings) as run:
                shapes = np.concatenate(list(run(_prior_shape, range(PRIOR_SHAPES))))
            with threadpool_limits(1):
                model = IntrinsicModel.train(template, shapes, PRIOR_DIMENSION, settings.seed)
            prior = (model.mean, model.basis, model.offset)
        with _worker_map(workers, settings, prior) as run:
            for meshes in run(_make, jobs):
                for mesh in meshes:
                    pending.append(mesh)
                    flipped.append(mesh.pop("flipped"))
                    rows.append(mesh.pop("measures") | {"identity": mesh["identity"]})
                    progress(len(rows), total)
                    if len(pending) == SHARD_SIZE:
                        yield _stack(pending)
                        pending = []
        if pending:
            yield _stack(pending)

    def manifest(entries):
        generator = np.random.default_rng([settings.seed, _SPLIT])
        people = np.array([row["identity"] for row in rows])
        splits = split_identities(range(settings.identities), generator)
        # A small draw can leave a split without anyone; then only those who were drawn are divided.
        if not all(np.isin(people, split).any() for split in splits.values()):
            splits = split_identities(np.unique(people).tolist(), generator)
        names = [name for name in rows[0] if name != "identity"]
        measures = np.array([[row[name] for name in names] for row in rows])
        training = np.isin([row["identity"] for row in rows], splits["train"])
        labels, thresholds = binary_labels(measures, names, training if training.any() else np.ones(len(rows), bool))
        value = {
            "settings": asdict(settings),
            "count": len(rows),
            "expressions": expressions,
            "kinds": list(KINDS),
            "exponents": list(EXPONENTS[: settings.levels]),
            "part_changes": list(NAMES),
            "changes": list(head.change_names),
            "flipped": float(np.mean(flipped)),
            "thresholds": dict(zip(names, thresholds.tolist(), strict=True)),
            "splits": splits,
        }
        if albedos:
            value["albedo"] = _write_albedos(folder, template, albedos, albedo_size, settings.seed)
        return value, {"attributes": np.array(names), "measures": measures.astype(np.float32), "labels": labels}

    write_dataset(folder, template, shards(), manifest)
    return {"meshes": len(rows), "flipped": float(np.mean(flipped))}


def _write_albedos(folder, template, count, size, seed):
    """Draw the albedos into their file. Returns its entry in the manifest."""
    painter, pictures = TexturePainter(template, size), np.empty((count, size, size, 3), np.uint8)
    for number in range(count):
        pictures[number] = painter.draw(random_look(np.random.default_rng([seed, _ALBEDO, number])))
    write_npz(folder / ALBEDO_FILE, {"albedo": pictures})
    digest = sha256_file(folder / ALBEDO_FILE)
    return {"file": ALBEDO_FILE, "count": count, "size": size, "seed": seed, "sha256": digest}


def _jobs(settings):
    """Units of work: lists of (identity, expression, level), or of one (index,) for a random draw."""
    if settings.count is None:
        return [
            [(identity, expression, level) for level in range(settings.levels)]
            for identity in range(settings.identities)
            for expression in range(settings.expressions)
        ]
    return [[(index,)] for index in range(settings.count)]


# ---------------------------------------------------------------- in the worker


class _Worker:
    """What every job needs, made once a process."""

    def __init__(self, settings, prior):
        self.settings, self.head = settings, load_head()
        self.template = self.head.template()
        self.expressions = list(_expression_table(self.head).values())[: settings.expressions]
        self.hold = self.template.mask(*DELICATE).astype(float)
        self.model = IntrinsicModel(self.template, *prior) if prior else None
        self._people = {}

    def person(self, number):
        """Identity and the similarity that aligns its neutral face to the template's; no triangle flipped."""
        if number not in self._people:
            generator = np.random.default_rng([self.settings.seed, _IDENTITY, number])
            for _ in range(200):
                identity = random_identity(self.head, generator)
                neutral = self.head.evaluate(**vars(identity))
                if not flipped_triangles(neutral, self.template.gradients).any():
                    break
            face = self.template.region("face")
            self._people[number] = identity, similarity(neutral[face], self.template.vertices[face])
        return self._people[number]

    def shape(self, number, expression):
        """Aligned vertices of a person with an expression."""
        identity, (scale, rotation, translation) = self.person(number)
        vertices = self.head.evaluate(**vars(identity), actions=self.expressions[expression])
        return scale * vertices @ rotation.T + translation

    def curvature(self, vertices, levels):
        exponents = [EXPONENTS[level] for level in levels]
        return exaggerate_curvature(vertices, self.template.faces, exponents, self.hold)

    def flipped(self, vertices):
        return float(flipped_triangles(vertices, self.template.gradients).mean())

    def row(self, vertices, identity, expression, level, kind, parts, hand):
        vertices = self.template.cavities.tuck(vertices)
        person, _ = self.person(identity)
        measures = measure_attributes(vertices, self.template, person.gender, person.age, kind > 0)
        changes = [person.changes.get(name, 0.0) for name in self.head.change_names]
        return {
            "vertices": vertices.astype(np.float32),
            "identity": identity,
            "expression": expression,
            "level": level + 1,
            "kind": kind,
            "gender": person.gender,
            "age": person.age,
            "weight": person.weight,
            "changes": np.array(changes, dtype=np.float32),
            "parts": parts.astype(np.float32),
            "hand": hand.astype(np.float32),
            "flipped": self.flipped(vertices),
            "measures": measures,
        }

    def draw(self, index):
        """One random mesh; redrawn with milder changes while too many triangles flip."""
        generator = np.random.default_rng([self.settings.seed, _DRAW, index])
        kind = generator.choice(len(KINDS), p=KIND_SHARES)
        if self.settings.levels == 1:
            kind &= 2
        strength = generator.uniform(*PART_STRENGTH)
        for _ in range(TRIES):
            identity = int(generator.integers(self.settings.identities))
            expression = int(generator.integers(self.settings.expressions))
            vertices, level, parts = self.shape(identity, expression), 0, np.zeros(len(NAMES))
            hand = np.zeros((81, 3))
            if kind & 1:
                level = int(generator.integers(1, self.settings.levels))
                vertices = self.curvature(vertices, [level])[0]
            if kind & 2:
                parts = random_part_changes(generator, strength)
                hand = random_hand(vertices[self.template.annotation.landmarks], generator, min(strength, 1.0))
                moved = exaggerate_parts(vertices, parts, hand, self.model)
                # Size and place of the face are kept, so that the exaggeration is of its proportions.
                face = self.template.region("face")
                scale, rotation, translation = similarity(moved[face], vertices[face])
                vertices = untangle(scale * moved @ rotation.T + translation, self.template.gradients)
            if self.flipped(vertices) <= MAX_FLIPPED:
                break
            strength *= 0.93
        return self.row(vertices, identity, expression, level, int(kind), parts, hand)


_worker = None


def _start(settings, prior):
    global _worker
    # Ctrl-C reaches the whole process group; the parent ends the workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threadpool_limits(1)
    _worker = _Worker(settings, prior)


def _prior_shape(index):
    generator = np.random.default_rng([_worker.settings.seed, _PRIOR, index])
    vertices = _worker.shape(_STRANGERS + index, int(generator.integers(_worker.settings.expressions)))
    return exaggerate_curvature(vertices, _worker.template.faces, [generator.uniform(0, EXPONENTS[-1])], _worker.hold)


def _make(job):
    if len(job[0]) == 1:
        return [_worker.draw(job[0][0])]
    identity, expression, _ = job[0]
    levels = [level for _, _, level in job]
    shapes = _worker.curvature(_worker.shape(identity, expression), levels)
    none = np.zeros(len(NAMES)), np.zeros((81, 3))
    pairs = zip(levels, shapes, strict=True)
    return [_worker.row(vertices, identity, expression, level, int(level > 0), *none) for level, vertices in pairs]


# ---------------------------------------------------------------- around the worker


@contextlib.contextmanager
def _worker_map(workers, settings, prior=None):
    """A map over jobs, in order, in fresh processes, which end with the context whatever happens."""
    context = multiprocessing.get_context("spawn")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    pool = ProcessPoolExecutor(workers or cores, mp_context=context, initializer=_start, initargs=(settings, prior))
    try:
        yield functools.partial(_map_unsignalled, pool)
    except BrokenProcessPool as error:
        raise CaricliError("a worker process was ended from outside; is there enough memory?") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _map_unsignalled(pool, function, jobs):
    # Workers start here and inherit the mask, so that Ctrl-C, which reaches them too, is left to the parent.
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.map(function, jobs)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def _expression_table(head):
    table = read_yaml(asset_path("expressions.yaml"))
    return {name: expand_sides(weights, head.action_names) for name, weights in table.items()}


def _stack(meshes):
    integers = ("identity", "expression", "level", "kind")
    return {
        name: np.array([m[name] for m in meshes], np.int32 if name in integers else np.float32) for name in meshes[0]
    }
