from types import SimpleNamespace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_portrait import (
    PortraitTally,
    RenderedPortraits,
    RenderSettings,
    mean_figures,
    refinement_gains,
)
from caricli.methods.evaluate.reconstruct_portrait import REFINED


def dataset(template, rows):
    """Stands in for a Dataset of four heads, some of them to test with."""
    return SimpleNamespace(
        template=template, vertices=np.array([template.vertices] * 4), rows=lambda split: np.isin(np.arange(4), rows)
    )


def test_rendered_portraits_are_of_the_test_meshes_and_depend_on_the_seed(head_template):
    portraits = RenderedPortraits(dataset(head_template, [1, 3]), RenderSettings(count=5, size=48))
    assert [portrait.name for portrait in portraits] == ["mesh 1", "mesh 3"] and len(portraits) == 2
    assert np.array_equal(portraits[1].image, portraits[1].image)
    other = RenderedPortraits(dataset(head_template, [1, 3]), RenderSettings(count=1, size=48, seed=1))
    assert len(other) == 1 and not np.array_equal(other[0].points, portraits[0].points)
    with pytest.raises(InputError, match="test split"):
        RenderedPortraits(dataset(head_template, []), RenderSettings())


def test_the_meshes_are_chosen_by_chance_and_each_is_drawn_by_itself(head_template, monkeypatch):
    def studio(template, size):
        return SimpleNamespace(portray=lambda name, vertices, generator, noise: (name, generator.random(), noise))

    monkeypatch.setattr("caricli.methods.evaluate.evaluate_portrait.PortraitStudio", studio)
    data = dataset(head_template, [0, 1, 2, 3])
    chosen = {tuple(RenderedPortraits(data, RenderSettings(count=2, seed=seed)).rows) for seed in range(8)}
    assert len(chosen) > 2 and all(first < second for first, second in chosen)
    alone = RenderedPortraits(dataset(head_template, [3]), RenderSettings(noise=0.7))[0]
    assert alone == RenderedPortraits(data, RenderSettings(noise=0.7))[3] and alone[2] == 0.7


def test_a_tally_counts_by_set_and_keeps_what_was_refused():
    tally = PortraitTally()
    figures = {"elastic": {"shape": 2.0}, "elastic" + REFINED: {"shape": 1.0}}
    for group, name in (("rendered", "a"), ("rendered", "b"), ("pictures", "c.png")):
        portrait = SimpleNamespace(name=name)
        tally.add(group, SimpleNamespace(portrait=portrait, figures=figures, refused={"morphable": f"no {name}"}))
    assert [tally.count(group) for group in ("rendered", "pictures", "others")] == [2, 1, 0]
    assert tally.refused["c.png, morphable"] == "no c.png"
    assert tally.summary["means"]["pictures"]["elastic"] == {"shape": 2.0}
    assert tally.summary["refinement"]["elastic"]["better"] == 2


def test_means_and_gains_take_the_faces_that_have_figures():
    name, fine = "elastic", "elastic" + REFINED
    faces = [
        {name: {"shape": 2.0, "nme": {"all": 1.0}}, fine: {"shape": 1.0, "nme": {"all": 0.5, "eyes": 3.0}}},
        {name: {"shape": 4.0, "nme": {"all": 2.0}}, fine: {"shape": 5.0, "nme": {"all": 0.1}}},
        {name: {"shape": 9.0, "nme": {"all": 3.0}}},
    ]
    means = mean_figures(faces)
    assert means == {
        name: {"shape": 5.0, "nme": {"all": 2.0}},
        fine: {"shape": 3.0, "nme": {"all": pytest.approx(0.3), "eyes": 3.0}},
    }
    assert refinement_gains(faces) == {name: {"faces": 2, "better": 1, "before": 3.0, "after": 3.0}}
