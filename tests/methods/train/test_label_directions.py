import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.train.label_directions import LabelTable, label_directions, measure_directions

PEOPLE, MESHES, DIMENSION = 30, 300, 6


@pytest.fixture(scope="module")
def space():
    """Latents, identities, and two measures: one along an axis, one along a slanted line with noise."""
    generator = np.random.default_rng(0)
    latents = generator.normal(size=(MESHES, DIMENSION))
    slant = np.array([0, 0.6, 0.8, 0, 0, 0])
    measures = np.c_[5 * latents[:, 0] + 1, latents @ slant + 0.3 * generator.normal(size=MESHES)]
    return latents, generator.integers(0, PEOPLE, MESHES), measures, np.array([np.eye(DIMENSION)[0], slant])


def test_normals_and_gradients_lie_along_the_measures(space):
    latents, people, measures, axes = space
    labels = measures > np.quantile(measures, 0.75, axis=0)
    calls = []
    table = LabelTable(["a", "b"], labels, people, measures)
    found, skipped = label_directions(latents, table, report=lambda *call: calls.append(call))
    assert found.names == ("a", "b") and skipped == {} and calls == [(1, 2), (2, 2)]
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1)
    assert ((found.normals * axes).sum(1) > 0.97).all()
    # One standard deviation of the first measure is one of the latent.
    np.testing.assert_allclose(found.gradients[0], axes[0], atol=0.05)
    np.testing.assert_allclose(found.change, (found.gradients * found.normals).sum(1))
    assert found.auc[0] > 0.99 and 0.9 < found.auc[1] < found.auc[0]
    assert found.positives.tolist() == labels.sum(0).tolist() and found.count == MESHES
    again, _ = label_directions(latents, table)
    assert np.array_equal(again.normals, found.normals)


def test_the_area_under_the_curve_is_of_people_never_seen(space):
    latents, people, *_ = space
    # Everyone has a latent of their own and a label that means nothing: only who was seen could be told.
    generator = np.random.default_rng(1)
    own, chance = 3 * generator.normal(size=(PEOPLE, 40)), generator.random(PEOPLE) < 0.5
    latents = own[people] + 0.1 * generator.normal(size=(MESHES, 40))
    found, _ = label_directions(latents, LabelTable(["x"], chance[people][:, None], people))
    assert found.auc[0] < 0.75
    assert not found.gradients.any() and not found.change.any()


def test_rare_labels_and_labels_of_one_class_are_left_out(space):
    latents, people, measures, _ = space
    order = np.argsort(measures[:, 0])
    rare, alone = np.zeros((2, MESHES), bool)
    rare[order[-9:]] = True
    alone[people == np.bincount(people).argmax()] = True
    labels = np.c_[measures[:, 0] > 1, rare, ~rare, np.ones(MESHES, bool), alone]
    table = LabelTable(["good", "rare", "common", "all", "alone"], labels, people)
    found, skipped = label_directions(latents, table)
    assert found.names == ("good",)
    assert "9 and 291" in skipped["rare"] and "291 and 9" in skipped["common"] and "one class" in skipped["all"]
    assert "people" in skipped["alone"] or "at least 10" in skipped["alone"]
    with pytest.raises(InputError, match="all: all 300 meshes are of one class"):
        label_directions(latents, table.columns([3]))


def test_a_label_whose_people_cannot_be_divided_is_left_out(space):
    """Of three people one is never as the label says, one always, and the folds put the third with either."""
    counts = [11, 3, 4, 10]
    people = np.repeat([0, 1, 1, 2], counts)
    alone = np.repeat([False, True, False, True], counts)
    latents = space[0][: len(people)]
    table = LabelTable(["mixed", "alone"], np.c_[latents[:, 0] > 0, alone], people)
    found, skipped = label_directions(latents, table)
    assert found.names == ("mixed",) and [*skipped] == ["alone"] and "on either side" in skipped["alone"]


def test_the_change_is_measured_on_meshes(pca):
    generator = np.random.default_rng(2)
    latents = generator.normal(size=(60, len(pca.prior.mean)))
    shapes = pca.decode(pca.prior.colour(latents))
    width = np.array([np.ptp(shape[pca.template.annotation.landmarks[[31, 35]], 0]) for shape in shapes])
    labels = (width > np.median(width))[:, None]
    found, _ = label_directions(latents, LabelTable(["WideNose"], labels, np.arange(60), width[:, None]))
    measured = measure_directions(found, latents[:4], pca, {"WideNose": 0.01})
    assert measured.change[0] > 0 and measured.change[0] != found.change[0]
    # The width of a nose is nearly linear in the latents of positions, so the gradient foretells the change.
    assert measured.gradients[0] @ measured.normals[0] == pytest.approx(measured.change[0], rel=0.05)
    # Half the spread, twice the change in its terms; labels that no mesh shows stay.
    finer = measure_directions(found, latents[:4], pca, {"WideNose": 0.005})
    assert finer.change[0] == pytest.approx(2 * measured.change[0])
    assert measure_directions(found, latents[:4], pca, {}) is found
