import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.unseen import fingerprints
from caricli.methods.train.see_faces import map_faces, see_faces


def test_faces_are_seen_from_random_sides(head_template):
    shapes = np.stack([head_template.vertices, head_template.vertices + 0.3])
    one, other = (see_faces(shape[None], head_template, 5, np.random.default_rng(4)) for shape in shapes)
    # Places do not matter; turns do.
    assert one.shape == (5, 68, 2)
    np.testing.assert_allclose(one, other, atol=1e-9)
    assert one.std(0).max() > 0.05
    again = see_faces(shapes[:1], head_template, 5, np.random.default_rng(5))
    assert np.abs(again - one).max() > 0.05


def test_those_who_are_learnt_from_are_named_apart_from_those_held_out(head_template):
    """Of 19 people of the training the tenth is held out, and the last one is in no mesh."""
    people = np.repeat([*range(18), 30, 31], 2)
    shapes = head_template.vertices * np.linspace(0.9, 1.1, len(people))[:, None, None]
    splits = {"train": [*range(19)], "validation": [30], "test": [31]}
    level = np.tile([1, 3], len(people) // 2)
    nothing = np.zeros((len(people), 0))
    data = Dataset(
        {"splits": splits}, head_template, shapes.astype("f4"), people, 0 * level, level, (), nothing, nothing > 0, {}
    )
    seen = map_faces(data, 1, 0).seen_people()
    marks = {person: own for split in splits for person, own in fingerprints(data, split).items()}
    learnt = [*range(9), *range(10, 18)]
    assert seen.train == frozenset().union(*(marks[person] for person in learnt)) and len(seen.train) == 2 * len(learnt)
    assert seen.validation == marks[9] | marks[30]
    assert not marks[31] & (seen.train | seen.validation)
