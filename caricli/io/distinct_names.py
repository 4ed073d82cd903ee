"""Short names that tell files apart."""

import os
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path


def distinct_names(paths: Sequence[Path], between: str = "/") -> list[str]:
    """The stem of every path; where two share one, what of the paths is not the same in all, joined by ``between``.

    Suffixes alone are no names, so stems go before them. One path that is given twice has the same name twice.
    """
    stems = [path.stem for path in paths]
    if len(set(stems)) == len(stems):
        return stems
    root = os.path.commonpath([path.parent.absolute() for path in paths])
    below = [path.absolute().relative_to(root) for path in paths]
    # From the end, because a folder may lie deeper than another.
    suffixes, *places = zip_longest(*(reversed((*path.parent.parts, path.stem, path.suffix[1:])) for path in below))
    columns = [parts for parts in reversed(places) if len(set(parts)) > 1] or [tuple(stems)]
    if len({*zip(*columns, strict=True)}) < len(set(below)):
        columns.append(suffixes)
    return [between.join(filter(None, parts)) or stem for *parts, stem in zip(*columns, stems, strict=True)]
