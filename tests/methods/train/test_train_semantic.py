from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from caricli.data.attributes import measure_attributes
from caricli.errors import InputError
from caricli.methods.train.train_semantic import LabelChoice, train_semantic


@pytest.fixture(scope="module")
def data(pca):
    """Stands in for a Dataset of 60 heads of as many people: a label along one latent, and one that all have."""
    latents = np.random.default_rng(0).normal(size=(60, len(pca.prior.mean)))
    measures = np.c_[latents[:, 0], np.ones(60)]
    return SimpleNamespace(
        manifest={},
        template=pca.template,
        vertices=pca.decode(pca.prior.colour(latents)).astype(np.float32),
        attributes=("Along", "All"),
        measures=measures,
        labels=np.c_[measures[:, 0] > 0, np.ones(60, bool)],
        identity=np.arange(60) % 55,
        level=np.r_[np.ones(57, int), [4, 3, 2]],
        regular=np.arange(60) < 57,
        rows=lambda split: (np.arange(60) < 50) == (split == "train"),
    )


def test_labels_are_learnt_and_people_are_kept(data, pca):
    stages = []

    @contextmanager
    def watch(stage):
        stages.append(stage)
        yield lambda done, total: None

    directions, skipped = train_semantic(pca, data, LabelChoice(count=40), watch)
    assert stages == ["encoding", "labels", "people"]
    assert directions.names == ("Along",) and "one class" in skipped["All"]
    assert directions.count == 40 and directions.model_id == pca.model_id
    assert np.argmax(np.abs(directions.normals[0])) == 0
    # Ten test meshes are of ten people.
    assert directions.people.shape == (10, len(pca.prior.mean))


def test_the_change_of_a_users_label_is_in_deviations_of_what_meshes_show(data, pca):
    """The user's label says who has a wide nose, the measure how wide noses are."""
    widths = np.array([measure_attributes(mesh, pca.template)["WideNose"] for mesh in data.vertices.astype(float)])
    labels = np.c_[widths > np.median(widths)]
    names = {"attributes": ("WideNose",), "labels": labels}
    built = {"measures": np.c_[widths], "manifest": {"thresholds": {}}}
    changes = [
        train_semantic(pca, SimpleNamespace(**vars(data) | names | parts), LabelChoice())[0].change
        for parts in (built, {"measures": labels.astype(float)})
    ]
    assert changes[0] > 0.3
    np.testing.assert_allclose(changes[1], changes[0], rtol=1e-6)


def test_of_a_person_the_most_regular_mesh_is_kept(data, pca):
    twice = SimpleNamespace(**vars(data) | {"identity": np.r_[np.arange(58), 57, 57]})
    directions, _ = train_semantic(pca, twice, LabelChoice(("Along",), 40))
    expected = pca.prior.whiten(pca.encode(data.vertices[[59]].astype(float)))[0]
    assert len(directions.people) == 8
    np.testing.assert_allclose(directions.people[-1], expected, atol=1e-6)


def test_a_mesh_of_which_parts_are_exaggerated_is_not_the_most_regular(data, pca):
    """Of the last person both meshes are of the first level."""
    changes = {"identity": np.r_[np.arange(58), 57, 57], "level": np.ones(60, int), "regular": np.arange(60) == 59}
    directions, _ = train_semantic(pca, SimpleNamespace(**vars(data) | changes), LabelChoice(("Along",), 40))
    expected = pca.prior.whiten(pca.encode(data.vertices[[59]].astype(float)))[0]
    np.testing.assert_allclose(directions.people[-1], expected, atol=1e-6)


def test_labels_that_cannot_be_learnt_are_refused_when_they_are_asked_for(data, pca):
    with pytest.raises(InputError, match="label All: all 50 meshes are of one class"):
        train_semantic(pca, data, LabelChoice(("All", "Along")))
    with pytest.raises(InputError, match="one of the labels Along, All, found 'Hat'"):
        train_semantic(pca, data, LabelChoice(("Hat",)))
    bare = SimpleNamespace(**vars(data) | {"attributes": ()})
    with pytest.raises(InputError, match="expected labels, found none"):
        train_semantic(pca, bare, LabelChoice())


def test_the_number_of_threads_changes_no_byte(data, pca):
    trained = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            trained.append(train_semantic(pca, data, LabelChoice(("Along",), 40))[0])
    for name in ("normals", "change", "people"):
        np.testing.assert_array_equal(getattr(trained[0], name), getattr(trained[1], name), err_msg=name)
