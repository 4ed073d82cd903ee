"""Some of many, from all over them."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def evenly(items: Sequence[T], count: int) -> list[T]:
    """At most so many of some items, as far from each other as they can be, the first and the last among them."""
    numbers = np.linspace(0, max(len(items) - 1, 0), min(count, len(items))).round().astype(int)
    return [items[number] for number in numbers]
