"""People whose textures are simple functions of their expressions, in place of generated ones."""

from dataclasses import replace

import numpy as np

from caricli.data.texture_set import ActedTextures, TextureWriter
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.structures.arkit import ARKIT_NAMES
from caricli.template.chart import face_chart

SHOWN = 4
SPLITS = {"train": [0, 1, 2, 3], "validation": [4, 5], "test": [6, 7]}
ACTIONS = ("jawOpen", "mouthSmileLeft", "browInnerUp")


def acted_people(head, size=32, age=0.5, **body):
    """Eight people of one shape: skin of one colour, darker where it moves, a mouth that is red as far as it gapes."""
    grid = ChartGrid(face_chart(head.template()), size)
    generator = np.random.default_rng(0)
    splits = {person: split for split, people in SPLITS.items() for person in people}
    return [_acted(head, grid, generator, (person, splits[person], age), body) for person in splits]


def _acted(head, grid, generator, person, body):
    neutral = head.evaluate(**body)
    weights = np.zeros((SHOWN, len(ARKIT_NAMES)), np.float32)
    vertices = []
    pictures = []
    skin = generator.uniform(0.4, 0.9, 3)
    for number in range(SHOWN):
        values = generator.uniform(0, 1, len(ACTIONS)) * (number > 0)
        weights[number, [ARKIT_NAMES.index(name) for name in ACTIONS]] = values
        shape = head.evaluate(**body, actions=dict(zip(ACTIONS, values, strict=True)))
        vertices.append(shape)
        moved = np.linalg.norm(grid.bake(shape - neutral), axis=-1, keepdims=True)
        colours = skin * np.exp(-30 * moved)
        colours[grid.mouth] = [0.3 + 0.6 * values[0], 0.1, 0.1]
        pictures.append(np.rint(255 * colours).astype(np.uint8))
    seen = np.broadcast_to(grid.covered, (SHOWN, *grid.covered.shape))
    return ActedTextures(
        np.stack(pictures), seen, weights, np.stack(vertices).astype(np.float32), neutral.astype(np.float32),
        person[0], 1, person[1], person[2],
    )  # fmt: skip


def write_acted_set(folder, head, size=32, shown=SHOWN, people=None, **body):
    """A folder of ``acted_people`` with so many of their expressions. people: fingerprints by split. Returns it."""
    folder.mkdir(parents=True)
    writer = TextureWriter(folder)
    for person in acted_people(head, size, **body):
        parts = {name: getattr(person, name)[:shown] for name in ("pictures", "seen", "weights", "vertices")}
        writer.add(replace(person, **parts))
    told = {} if people is None else {"people": people}
    writer.finish({"size": size, "expressions": shown, "splits": SPLITS, **told})
    return folder
