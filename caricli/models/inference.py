"""Networks that say the same whatever machine they run on."""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import ParamSpec, TypeVar

import torch

P = ParamSpec("P")
R = TypeVar("R")
_alone = RLock()


def on_one_core(function: Callable[P, R]) -> Callable[P, R]:
    """What runs a small network without gradients, the same to the last bit however many cores there are.

    Sums over a layer's inputs are otherwise taken in as many parts as there are threads; and threads that wait for each
    other while others work take twenty times as long for one picture as one of them alone.
    """

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        # The number is the whole process's: one that was set beside another would stay, or end too soon.
        with _alone:
            threads = torch.get_num_threads()
            torch.set_num_threads(1)
            try:
                with torch.inference_mode():
                    return function(*args, **kwargs)
            finally:
                torch.set_num_threads(threads)

    return run
