"""SIGINT and SIGTERM as an exception, raised only where Python can stand one."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ASK_AGAIN = 0.05
"""Seconds until a signal that was put off, or whose exception was swallowed, is looked at again."""


class Stopped(SystemExit):
    """A signal asked for an end. Not an Exception, so that nothing mistakes it for a failure it may swallow."""

    def __init__(self, number: int) -> None:
        """number: of the signal."""
        super().__init__(number)
        self.number = number


class _Request:
    """What the process was asked for: the first signal that came, and how many `held` and `raising` are open."""

    def __init__(self) -> None:
        self.number: int | None = None
        self.holds = 0
        self.raises = 0


_request = _Request()


@contextmanager
def raising() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise `Stopped` in the main thread, so that half-written outputs are removed on the way.

    It is put off while a module is imported (an extension that is made under an exception ends the process or blames
    something else) and within `held`; it is raised again where a library's callback swallowed it; it never interrupts
    what cleans up after it. Whatever failure reaches the end of the context after a signal is `Stopped`.
    In other threads than the main one, which no signal reaches, this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _request.number = None
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    handlers = dict.fromkeys(numbers, _handler_of(os.getpid())) | {signal.SIGALRM: _ask_again}
    previous = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    hook = sys.unraisablehook
    sys.unraisablehook = _quiet
    _request.raises += 1
    try:
        yield
    except BaseException as error:
        if _request.number is None or isinstance(error, Stopped):
            raise
        raise Stopped(_request.number) from error
    finally:
        # First: an alarm that is on its way would set the clock again, and Python ends without a handler for it.
        _request.raises -= 1
        signal.setitimer(signal.ITIMER_REAL, 0)
        sys.unraisablehook = hook
        # After a stop the process ends, and a second signal must not change how.
        for number, handler in previous.items() if _request.number is None else ():
            signal.signal(number, handler)


@contextmanager
def held() -> Iterator[None]:
    """Put a stop off until the end of the context: for steps that must not be left half done."""
    _request.holds += 1
    try:
        yield
    finally:
        _request.holds -= 1
    if not _request.holds:
        raise_if_asked()


def raise_if_asked() -> None:
    """Raise `Stopped` when a signal came: also within `held`, where all can still be taken back."""
    if _request.number is not None and not _is_cleaning_up():
        raise Stopped(_request.number)


def _handler_of(owner: int) -> Callable[[int, FrameType | None], None]:
    def stop(number: int, frame: FrameType | None) -> None:
        if os.getpid() != owner:  # a forked worker inherits this handler and has nothing of its own to remove
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        elif _request.number is None:  # timeout(1) and shells signal twice
            _request.number = number
            _ask_again(number, frame)

    return stop


def _ask_again(_: int, frame: FrameType | None) -> None:
    if _request.number is None or not _request.raises:
        return
    signal.setitimer(signal.ITIMER_REAL, ASK_AGAIN)
    if not _request.holds and not _is_importing(frame):
        raise_if_asked()


def _quiet(unraisable: "sys.UnraisableHookArgs") -> None:
    """Say nothing of a `Stopped` that a finaliser or a callback swallowed: it is raised again."""
    if unraisable.exc_type is not Stopped:
        sys.__unraisablehook__(unraisable)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _is_cleaning_up() -> bool:
    """Whether `Stopped` is on its way through the handlers and contexts that are open."""
    error = sys.exception()
    while error is not None:
        if isinstance(error, Stopped):
            return True
        error = error.__context__
    return False
