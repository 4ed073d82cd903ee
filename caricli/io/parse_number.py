"""Numbers as people and programs write them, read in one way everywhere.

Python's own ``int`` and ``float`` take more than anybody means: 1_0 is ten, blanks around a number do not count, and
neither does in which script its digits are; nan and infinity are numbers.
"""

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_NUMBER = re.compile(rb"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_LETTERS = re.compile(rb"[-+.eE0-9]+")
_WHOLE = re.compile(rb"[-+]?(?:0|[1-9][0-9]{0,17})")


def parse_number(text: str | bytes) -> float:
    """A finite decimal number such as 1, -0.5, .5 or 1e-3. Raises ValueError for any other text."""
    data = text if isinstance(text, bytes) else text.encode("utf-8", "replace")
    if not _NUMBER.fullmatch(data):
        raise ValueError("no decimal number")
    value = float(data)
    if not math.isfinite(value):
        raise ValueError("a number that is too large")
    return value


def parse_numbers(words: Sequence[bytes]) -> "np.ndarray":
    """Many numbers (N,) as ``parse_number`` takes them, quickly. Raises ValueError where one is none."""
    # Here, because the command line parses its options without NumPy.
    import numpy as np

    if words and not _LETTERS.fullmatch(b"".join(words)):
        raise ValueError("others than decimal numbers")
    values = np.fromiter(map(float, words), np.float64, len(words))
    if not np.isfinite(values).all():
        raise ValueError("a number that is too large")
    return values


def parse_whole(text: str | bytes) -> int:
    """A whole number of at most 18 digits, without zeros before it. Raises ValueError for any other text."""
    data = text if isinstance(text, bytes) else text.encode("utf-8", "replace")
    if not _WHOLE.fullmatch(data):
        raise ValueError("no whole number")
    return int(data)
