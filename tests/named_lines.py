"""Lines of sketches by the names of their curves."""


def points_by_curve(sketch):
    """Points (N, 2) of the strokes that have a curve's name, each of which is drawn once."""
    named = [stroke for stroke in sketch.strokes if stroke.curve is not None]
    lines = {stroke.curve: stroke.points for stroke in named}
    assert len(lines) == len(named)
    return lines
