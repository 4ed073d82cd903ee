"""The texture network that comes with caricli, and users' own."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from caricli.data.expressions import named_expressions
from caricli.methods.dynamic.change_atlas import change_atlas
from caricli.methods.dynamic.rig_moods import USUAL_MOODS, MoodPainter
from caricli.models.texture.model import TextureModel, texture_from_checkpoint
from caricli.store.bundled import load_bundled
from caricli.structures import Rig

BUNDLED = "texture.safetensors"


def load_texture_network(path: Path | None = None) -> TextureModel:
    """Load the texture network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, texture_from_checkpoint, path)


def paint_moods(rig: Rig, painter: MoodPainter, expressions: Mapping[str, Mapping[str, float]]) -> Rig:
    """A rig with pictures of its skin, and with the changes that its expressions make to it.

    Pictures are of every expression, or, where these are ARKit's single actions, of ``USUAL_MOODS``.

    painter: MoodPainter of the rig. expressions: actions with weights of its expressions, by their names.
    """
    moods = {name: {name: 1.0} for name in rig.names}
    if all(expressions[name] == {name: 1.0} for name in rig.names):
        usual = named_expressions(rig.names)
        moods = {name: usual[name] for name in USUAL_MOODS}
    return replace(rig, moods=painter.moods(moods), changes=change_atlas(painter))
