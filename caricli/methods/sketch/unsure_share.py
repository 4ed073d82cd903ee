"""How many strokes of a sketch seem to draw no line of a face."""

from caricli.methods.sketch.line_handles import LineHandles, with_own_names
from caricli.structures.sketch import Sketch, StrokeKind


def unsure_share(sketch: Sketch, named: Sketch, handles: LineHandles) -> float:
    """Share of the strokes without a curve's name, and no wrinkles, that found none, 0 to 1; 0 where most strokes name
    their curves, beside which wrinkles need no name.

    named: of ``name_strokes``, where one stroke may have become several. handles: LineHandles of the head.
    """
    own = with_own_names(sketch, handles)
    given = {stroke.curve for stroke in own.strokes if stroke.curve is not None}
    if 2 * sum(stroke.curve is not None for stroke in own.strokes) > len(own.strokes):
        return 0.0
    plain = {stroke.points.tobytes() for stroke in own.strokes if stroke.kind == StrokeKind.WRINKLE}
    asked = [s for s in named.strokes if s.curve not in given and s.points.tobytes() not in plain]
    return sum(s.curve is None and s.kind != StrokeKind.WRINKLE for s in asked) / len(asked) if asked else 0.0
