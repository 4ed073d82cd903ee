"""The texture of a face in expressions that it does not show (expressions paper, section 3.3)."""

from caricli.methods.dynamic.rig_moods import MoodPainter
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.rig_blendshapes import rig_blendshapes
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.make_rig import RigSettings
from caricli.models.texture.model import TextureModel
from caricli.structures import Face, Mood
from caricli.structures.head_choice import BARE


def paint_expressions(face: Face, tools: ExpressionTools, model: TextureModel) -> tuple[tuple[Mood, ...], list[str]]:
    """The texture of a face as each expression shows it, the expressions made as `blendshapes` makes them.

    face: Face with the camera of its picture, its landmarks and its texture. tools: ExpressionTools of its topology and
    of the expressions. model: TextureModel of the topology.
    Returns a Mood for every expression, as large as the texture, the neutral one first, and what the picture does not
    tell, for messages. Raises InputError as ``MoodPainter`` does, and for a face of another topology.
    """
    blendshapes = build_blendshapes(face, tools)
    rig = rig_blendshapes(blendshapes, tools, RigSettings(head=BARE), face.pictures, face).rig
    painter = MoodPainter(rig, tools.morphable.template, model)
    moods = {name: {} if name not in rig.names else {name: 1.0} for name in tools.expressions}
    return painter.moods(moods), painter.unknown()
