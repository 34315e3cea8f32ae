"""Ctrl-C and SIGTERM end the program at once, with one line and the exit code of the signal.

``cli`` imports this file while Python may still look for modules in the working folder: nothing
but what is built into Python is imported here.
"""

import _signal  # type: ignore[import-not-found]
import os

SIGINT: int = _signal.SIGINT

#: The exit code of a signal is 128 more than its number (128 + 2 for Ctrl-C).
SIGNALS = {
    getattr(_signal, name): name
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if hasattr(_signal, name)
}


class Stopped(KeyboardInterrupt):
    """A signal came while something was half done."""


class _State:
    """The state of this process."""

    signal = 0
    """The signal that came; 0: none."""
    unfinished = 0
    """How many ``Unfinished`` it is within."""
    speaks = True
    told = ""
    """The text behind the signal in the line."""


def end_on_signals(speaks: bool = True) -> None:
    """Let signals end this process, with a line on standard error or without."""
    _State.speaks = speaks
    for number in SIGNALS:
        if _signal.getsignal(number) != _signal.SIG_IGN:  # nohup ignores SIGHUP
            _signal.signal(number, _come)


def tell(text: str) -> None:
    """Say this in the line, too."""
    _State.told = text


def line(number: int) -> str:
    """What is said when a signal ends the program."""
    return f"stopped by {SIGNALS[number]}{_State.told}"


class Unfinished:
    """Within it a signal raises ``Stopped``, so that what is half done is undone.

    The program then ends where the outermost of them does: no other code can keep it alive.
    """

    def __enter__(self) -> None:
        _State.unfinished += 1

    def __exit__(self, *_: object) -> None:
        _State.unfinished -= 1
        if _State.signal and not _State.unfinished:
            end(_State.signal)


def end(number: int) -> None:
    """End the process here: the handlers of ``atexit`` and ``finally`` could take long."""
    if _State.speaks:
        os.write(2, f"{line(number)}\n".encode())
    os._exit(128 + number)


def _come(number: int, _: object) -> None:
    for ended_by in SIGNALS:
        _signal.signal(ended_by, _signal.SIG_IGN)  # what is half done is undone once
    _State.signal = number
    if _State.unfinished:
        raise Stopped
    end(number)
