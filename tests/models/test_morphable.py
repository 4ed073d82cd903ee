import numpy as np
import pytest

from caricli.errors import InputError, NumericsError
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint
from caricli.models.linear_basis import LinearBasis
from caricli.models.morphable.config import MorphableConfig
from caricli.models.morphable.model import MorphableModel, MorphableShapes, ShapeBases
from caricli.models.morphable.separate import separate

PEOPLE, SHOWN = (a.ravel() for a in np.meshgrid(np.arange(30), np.arange(4), indexing="ij"))


@pytest.fixture(scope="module")
def truth(balls):
    """(faces (30, 300, 3), effects (4, 300, 3)): who and what, the first expression none."""
    generator = np.random.default_rng(2)
    wave = np.sin(balls[0] @ generator.normal(size=(3, 3)) * 3)
    effects = 0.1 * generator.normal(size=(4, 1, 3)) * wave * generator.uniform(0.5, 1, (4, 300, 1))
    effects[0] = 0
    return balls, effects


@pytest.fixture(scope="module")
def shapes(truth):
    faces, effects = truth
    return faces[PEOPLE] + effects[SHOWN]


@pytest.fixture(scope="module")
def albedos():
    return np.random.default_rng(0).integers(0, 256, (9, 300, 3), dtype=np.uint8)


@pytest.fixture(scope="module")
def model(ball_template, shapes, albedos):
    data = MorphableShapes(shapes, PEOPLE, SHOWN, albedos)
    return MorphableModel.train(ball_template, data, MorphableConfig(5, 3, 4, noise=1e-3))


def test_who_and_what_are_found_apart(truth, shapes):
    faces, offsets = separate(shapes.reshape(len(shapes), -1), PEOPLE, SHOWN, 5)
    assert np.abs(faces - truth[0].reshape(30, -1)[PEOPLE]).max() < 1e-3
    assert np.abs(offsets - truth[1].reshape(4, -1)[SHOWN]).max() < 1e-3


def test_who_and_what_are_found_apart_where_people_show_different_expressions(truth):
    kept = np.random.default_rng(3).random(len(PEOPLE)) < 0.6
    people, shown = PEOPLE[kept], SHOWN[kept]
    shapes = truth[0][people] + truth[1][shown]
    _, offsets = separate(shapes.reshape(len(shapes), -1), people, shown, 5)
    expected = truth[1].reshape(4, -1)[shown]
    assert np.sqrt(((offsets - expected) ** 2).mean()) < 0.05 * np.sqrt((expected**2).mean())


def test_what_one_face_alone_does_counts_as_expression(truth):
    generator = np.random.default_rng(4)
    own = np.zeros((len(PEOPLE), 300, 3))
    own[:, :20] = generator.normal(0, 0.3, (len(PEOPLE), 1, 1)) * generator.normal(size=(20, 3))
    own *= (SHOWN > 0)[:, None, None]
    shapes = truth[0][PEOPLE] + truth[1][SHOWN] + own
    _, offsets = separate(shapes.reshape(len(shapes), -1), PEOPLE, SHOWN, 2)
    offsets = offsets.reshape(own.shape)
    assert not offsets[SHOWN == 0].any()
    found = offsets - np.stack([offsets[SHOWN == k].mean(0) for k in range(4)])[SHOWN]
    assert np.corrcoef(found[:, :20].ravel(), own[:, :20].ravel())[0, 1] > 0.8


def test_the_numbers_of_people_and_expressions_do_not_matter_but_that_of_none(shapes):
    rows = shapes.reshape(len(shapes), -1)
    first = separate(rows, PEOPLE, SHOWN, 5)
    other = separate(rows, 1000 - 7 * PEOPLE, np.array([0, 90, 5, 11])[SHOWN], 5)
    assert all(np.abs(a - b).max() < 1e-4 for a, b in zip(first, other, strict=True))


def test_faces_without_expressions_have_an_empty_basis(ball_template, balls, albedos):
    people = np.arange(30)
    data = MorphableShapes(balls, people, np.zeros(30, int), albedos)
    model = MorphableModel.train(ball_template, data, MorphableConfig(5, 3, 4))
    assert model.expression.shape == (0, 300, 3) and len(model.prior.mean) == 5
    assert np.abs(model.decode(model.encode(balls)) - balls).max() < 0.05


def test_decode_is_the_mean_with_both_bases(model):
    latent = np.linspace(-1, 1, 8)
    who, what = model.parts(latent)
    assert len(who) == 5 and len(what) == 3
    expected = model.mean + np.tensordot(who, model.identity, 1) + np.tensordot(what, model.expression, 1)
    assert np.abs(model.decode(latent) - expected).max() < 1e-12


def test_bases_are_one_standard_deviation_long(model, shapes):
    who, what = model.parts(model.encode(shapes))
    assert np.abs(who[SHOWN == 0].std(0) - 1).max() < 0.1
    assert np.abs(np.sqrt((what**2).mean(0)) - 1).max() < 0.1


def test_one_person_keeps_the_identity_and_one_expression_the_coefficients(model, shapes):
    who, what = model.parts(model.encode(shapes))
    assert np.abs(who - who.reshape(30, 4, -1).mean(1)[PEOPLE]).max() < 0.1
    assert np.abs(what - what.reshape(30, 4, -1).mean(0)[SHOWN]).max() < 0.1
    assert np.abs(what[SHOWN == 0]).max() < 0.1


def test_encode_is_the_likeliest_latent(ball_template, model, shapes):
    bases = ShapeBases(model.mean, model.identity, model.expression, noise=0.5)
    noisy = MorphableModel(ball_template, bases, LinearBasis(model.mean, model.identity))
    latent = noisy.encode(shapes[3])

    def cost(z):
        return ((noisy.decode(z) - shapes[3]) ** 2).sum() / 0.5**2 + (z**2).sum()

    assert all(cost(latent) < cost(latent + 1e-2 * step) for step in (*np.eye(8), *-np.eye(8)))


def test_colours_are_the_mean_with_the_albedo_basis(model, albedos):
    assert np.abs(model.colours(np.zeros(4)) - albedos.mean(0) / 255).max() < 1e-6
    bright = model.colours(np.full((2, 4), 40.0))
    assert bright.shape == (2, 300, 3) and bright.min() >= 0 and bright.max() <= 1


def test_a_checkpoint_rebuilds_it(model, shapes):
    again = model_from_checkpoint(*model_to_checkpoint(model, {}), "m")
    assert again.kind == "morphable" and again.noise == pytest.approx(model.noise)
    assert np.abs(again.decode(model.encode(shapes)) - model.decode(model.encode(shapes))).max() < 2e-3
    assert np.abs(again.albedo.basis - model.albedo.basis).max() < 1e-3


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("identity", lambda a: a[:, :-1]),
        ("expression", lambda a: a[0]),
        ("albedo_mean", lambda a: a[:-1]),
        ("noise", lambda a: a * 0),
    ],
)
def test_tensors_that_do_not_fit_are_refused(model, name, change):
    tensors, metadata = model_to_checkpoint(model, {})
    with pytest.raises(InputError, match="m: not a valid model"):
        model_from_checkpoint(tensors | {f"model.{name}": change(tensors[f"model.{name}"])}, metadata, "m")
    del tensors[f"model.{name}"]
    with pytest.raises(InputError, match="m: not a valid model"):
        model_from_checkpoint(tensors, metadata, "m")


def test_faces_that_are_all_the_same_are_refused(ball_template, balls, albedos):
    data = MorphableShapes(balls[[0, 0, 0]], np.arange(3), np.zeros(3, int), albedos)
    with pytest.raises(NumericsError, match="differ"):
        MorphableModel.train(ball_template, data, MorphableConfig())
