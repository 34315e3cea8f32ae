"""The command line ``urdf2mbs``."""

import signal
import sys

#: The signals that end a command, as far as this system has them.
SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]


def main(argv: list[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: The words of the command line; None: those of this process, in which SIGTERM and
            SIGHUP then also remove temporary files, as Ctrl-C does.

    Returns:
        The exit code: 0 done, 1 a fault of the robot, 2 of the usage, 3 not the same robot; 128
        plus its number after a signal.
    """
    try:
        for number in SIGNALS if argv is None else ():
            if signal.getsignal(number) != signal.SIG_IGN:  # nohup ignores SIGHUP
                signal.signal(number, _stop)
        from urdf2mbs.commands import carry_out

        return carry_out(sys.argv[1:] if argv is None else argv)
    except KeyboardInterrupt as stopped:
        ended_by = signal.Signals(stopped.args[0] if stopped.args else signal.SIGINT)
        print(f"stopped by {ended_by.name}", file=sys.stderr)
        return 128 + ended_by


def _stop(number: int, _: object) -> None:
    """End the command; further signals are ignored."""
    for each in SIGNALS:
        signal.signal(each, signal.SIG_IGN)  # temporary files are removed once
    raise KeyboardInterrupt(number)
