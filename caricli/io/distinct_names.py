"""Short names that tell files apart."""

import os
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path


def distinct_names(paths: Sequence[Path], between: str = "/") -> list[str]:
    """The stem of every path; where two share one, what of the paths is not the same in all, joined by ``between``.

    Suffixes do not count: of one thing in two formats the names are the same, as those of a path that is given twice.
    """
    stems = [path.stem if path.stem.strip(".") else path.name for path in paths]
    if len(set(stems)) == len(stems):
        return stems
    # Without its dots, which would be names.
    places = [Path(os.path.abspath(path)) for path in paths]
    root = os.path.commonpath([place.parent for place in places])
    below = [place.relative_to(root) for place in places]
    # From the end, because a folder may lie deeper than another.
    levels = [*zip_longest(*(reversed((*path.parent.parts, stem)) for path, stem in zip(below, stems, strict=True)))]
    columns = [parts for parts in reversed(levels) if len(set(parts)) > 1] or [tuple(stems)]
    return [between.join(filter(None, parts)) or stem for *parts, stem in zip(*columns, stems, strict=True)]
