"""The command line ``urdf2mbs``.

``--version`` is answered before anything else is imported: an editor and a CI ask for it often.
"""

from __future__ import annotations

import sys


def main(argv: list[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: The words of the command line; None: those of this process, in which SIGTERM and
            SIGHUP then also remove temporary files, as Ctrl-C does.

    Returns:
        The exit code: 0 done, 1 a fault of the robot, 2 of the usage, 3 not the same robot; 128
        plus its number after a signal.
    """
    command_line = sys.argv[1:] if argv is None else argv
    if command_line == ["--version"]:
        from urdf2mbs.disk.version import find_version

        print(f"urdf2mbs {find_version()}")
        return 0
    import signal

    try:
        if argv is None:
            _catch_signals()
        from urdf2mbs.commands import carry_out

        return carry_out(command_line)
    except KeyboardInterrupt as stopped:
        ended_by = signal.Signals(stopped.args[0] if stopped.args else signal.SIGINT)
        print(f"stopped by {ended_by.name}", file=sys.stderr)
        return 128 + ended_by


def _catch_signals() -> None:
    """Let SIGTERM and SIGHUP end a command as Ctrl-C does."""
    import signal

    for number in _list_signals():
        if signal.getsignal(number) != signal.SIG_IGN:  # nohup ignores SIGHUP
            signal.signal(number, _stop)


def _list_signals() -> list[int]:
    """Return the signals that end a command, as far as this system has them."""
    import signal

    names = ("SIGINT", "SIGTERM", "SIGHUP")
    return [getattr(signal, name) for name in names if hasattr(signal, name)]


def _stop(number: int, _: object) -> None:
    """End the command; further signals are ignored."""
    import signal

    for each in _list_signals():
        signal.signal(each, signal.SIG_IGN)  # temporary files are removed once
    raise KeyboardInterrupt(number)
