from dataclasses import replace

import numpy as np
import pytest

from caricli.data.exaggerate_own import STRETCHES, UsualFace, Whim, exaggerate_own, random_field, random_whim
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle


@pytest.fixture(scope="module")
def usual(head_template, people):
    features = np.array([head_template.gradients.features(face) for face in people[:30]])
    return UsualFace(head_template, features.mean(0), features.std(0))


@pytest.fixture(scope="module")
def someone_usual(usual, people, head_template):
    """UsualFace of whom one of the people is the usual face."""
    deviation = np.array([head_template.gradients.features(face) for face in people[:30]]).std(0)
    return UsualFace(head_template, head_template.gradients.features(people[30]), deviation)


@pytest.fixture(scope="module")
def plain(head_template):
    """Exaggerates what stands out, without whims."""
    count = len(head_template.vertices)
    return Whim(1.5, 1.0, np.ones(count), np.zeros((count, 3)), np.zeros(count))


def at(template, name):
    """(V,) one in a region, soft around it."""
    places = template.vertices
    centre = places[template.region(name)].mean(0)
    return np.exp(-0.5 * (np.linalg.norm(places - centre, axis=1) / (0.06 * template.height)) ** 2)


def aligned(shape, like, region):
    scale, rotation, translation = similarity(shape[region], like[region])
    return scale * shape @ rotation.T + translation


def test_the_usual_face_stays_as_it_is(someone_usual, people, plain):
    same = exaggerate_own(people[30], people[30], plain, someone_usual)
    np.testing.assert_allclose(same - same.mean(0), people[30] - people[30].mean(0), atol=1e-6)


def test_what_stands_out_grows_more_than_in_proportion(usual, people, plain, head_template):
    skin = np.setdiff1d(head_template.region("face"), np.flatnonzero(usual.lids > 0.05))

    def growth(power):
        """Factors of the differences where they are least and where they are most unusual, as medians."""
        ratios = []
        for face in people[30:34]:
            whim = replace(plain, power=power)
            shapes = [face, exaggerate_own(face, face, whim, usual)]
            sizes = [
                np.sqrt(usual.near(np.square(usual.gradients.features(each) - usual.mean).sum(1))) for each in shapes
            ]
            order = np.argsort((sizes[0] / usual.difference)[skin])
            ratio = (sizes[1] / sizes[0])[skin][order]
            ratios.append([np.median(part) for part in np.array_split(ratio, 5)])
        return np.mean(ratios, axis=0)

    steps = growth(1.0)
    even = growth(0.0)
    assert even.max() < 1.05 * even.min()
    assert (np.diff(steps) > 0).all() and steps[-1] > 1.3 * steps[0]
    # Small differences pay for the large ones.
    assert steps[0] < 0.9 * even[0] and steps[-1] > 1.05 * even[-1]


def test_a_large_nose_shrinks_what_lies_around_it(someone_usual, people, plain, head_template):
    sizes = 0.5 * at(head_template, "nose")[:, None] * np.ones(3)
    after = exaggerate_own(people[30], people[30], replace(plain, sizes=sizes), someone_usual)
    stretch = (someone_usual.gradients.features(after) - someone_usual.mean)[:, STRETCHES].mean(1)
    places = head_template.vertices / head_template.height
    away = np.linalg.norm(places - places[head_template.region("nose")].mean(0), axis=1)
    face = head_template.mask("face")
    assert stretch[head_template.region("nose")].mean() > 0.1
    assert stretch[face & (away > 0.15) & (away < 0.25)].mean() < -0.015
    assert np.abs(stretch[face & (away > 0.4)]).mean() < 0.01


def test_exaggeration_is_as_local_as_attention(usual, people, plain, head_template):
    face = people[31]
    attention = 1 + at(head_template, "chin")
    shapes = [
        exaggerate_own(face, face, replace(plain, attention=a), usual) for a in (np.ones_like(attention), attention)
    ]
    sizes = [np.linalg.norm(usual.gradients.features(shape) - usual.mean, axis=1) for shape in shapes]
    chin, brows = head_template.region("chin"), head_template.region("forehead")
    assert sizes[1][chin].mean() > 1.15 * sizes[0][chin].mean()
    # What draws the eye does so at the cost of the rest.
    assert sizes[1][brows].mean() < sizes[0][brows].mean()


def test_expressions_move_more_what_is_larger(usual, people, plain, head, head_template):
    neutral = head.evaluate(actions={})
    smile = head.evaluate(actions={"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "eyeBlinkLeft": 1.0})

    def moved(temper):
        whim = replace(plain, temper=np.full(len(neutral), temper))
        shapes = [usual.gradients.features(exaggerate_own(v, neutral, whim, usual)) for v in (smile, neutral)]
        return np.linalg.norm(shapes[0] - shapes[1], axis=1)

    calm, lively = moved(-1.0), moved(1.0)
    lips = head_template.region("lips")
    assert lively[lips].mean() > 1.5 * calm[lips].mean()
    lids = np.flatnonzero(usual.lids > 0.95)
    np.testing.assert_allclose(lively[lids].mean(), calm[lids].mean(), rtol=0.1)


def test_fields_have_variance_one_and_the_sides_that_are_asked_for(head_template):
    places = head_template.vertices / head_template.height / 0.1
    mirror = head_template.annotation.mirror
    fields = np.array([random_field(places, 0.3, np.random.default_rng(k)) for k in range(60)])
    away = np.abs(places[:, 0]) > 1.5
    assert 0.8 < fields[:, away].var() < 1.2
    odd = (fields - fields[:, mirror]) / 2
    assert 0.2 < odd[:, away].var() / fields[:, away].var() < 0.4
    same = random_field(places, 0.0, np.random.default_rng(1))
    mirrored = random_field(places * [-1, 1, 1], 0.0, np.random.default_rng(1))
    np.testing.assert_allclose(same, mirrored, atol=1e-9)


def test_the_seed_decides_a_whim_and_mildness_tames_it(head_template):
    def draw(seed, mildness=1.0):
        return random_whim(head_template.vertices, head_template.height, np.random.default_rng(seed), mildness)

    first, again, other, mild = draw(1), draw(1), draw(2), draw(1, 0.5)
    np.testing.assert_array_equal(first.sizes, again.sizes)
    np.testing.assert_array_equal(first.attention, again.attention)
    assert np.abs(first.sizes - other.sizes).max() > 0.05
    np.testing.assert_allclose(mild.sizes, 0.5 * first.sizes)
    assert mild.strength == 0.5 * first.strength and mild.power == first.power


@pytest.mark.parametrize("seed", range(3))
def test_a_caricature_is_bold_unlike_on_both_sides_and_not_torn(usual, people, head_template, seed):
    face, region, mirror = people[35 + seed], head_template.region("face"), head_template.annotation.mirror
    whim = random_whim(head_template.vertices, head_template.height, np.random.default_rng(seed))
    before = face.copy()
    shape = untangle(aligned(exaggerate_own(face, face, whim, usual), face, region), usual.gradients)
    np.testing.assert_array_equal(face, before)
    assert flipped_triangles(shape, usual.gradients).mean() < 1e-3
    assert np.linalg.norm(shape - face, axis=1)[region].mean() > 0.01 * head_template.height

    def sides(vertices):
        other = aligned(vertices[mirror] * [-1, 1, 1], vertices, region)
        return np.linalg.norm(vertices - other, axis=1)[region].mean()

    assert sides(shape) > 1.5 * sides(face)
