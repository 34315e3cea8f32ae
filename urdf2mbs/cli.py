"""The command line ``urdf2mbs``."""

import signal
import sys

#: The signals that end a command, as far as this system has them.
SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]


def main(argv: list[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same).

    A signal gives 128 plus its number.  Without ``argv`` the process is ours: then SIGTERM and
    SIGHUP, too, undo what is half done, as Ctrl-C does.
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
    for other in SIGNALS:
        signal.signal(other, signal.SIG_IGN)  # what is half done is undone once
    raise KeyboardInterrupt(number)
