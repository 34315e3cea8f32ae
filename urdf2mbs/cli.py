"""The command line: reads its words, carries the command out, and says what went wrong."""

from __future__ import annotations

import atexit
import gc
import os
import sys

from urdf2mbs.commands import module_of, parse

# What more a command needs is imported when it runs, so that help comes at once.
TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same)."""
    if argv is None:
        # This process is ours: at its end the collector would look through all that there is, and
        # find nothing worth the time.
        atexit.register(gc.freeze)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed, as for a service: nobody reads it
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # a robot's name may have letters that this terminal or pipe has not
            reconfigure(errors="backslashreplace")
    arguments = parse(sys.argv[1:] if argv is None else argv)
    from urdf2mbs.collector import seldom_collected

    with seldom_collected():  # it would look through all that is imported, too
        return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    import signal
    from contextlib import suppress

    from urdf2mbs.commands.colours import shown
    from urdf2mbs.commands.streams import quiet

    with suppress(ValueError):  # only the main thread is asked to end
        signal.signal(signal.SIGTERM, _stop)
    with shown(arguments.color), quiet(getattr(arguments, "quiet", False)):
        return _carry_out(arguments)


def _carry_out(arguments: argparse.Namespace) -> int:
    from errno import ENOSPC
    from pathlib import Path

    from urdf2mbs.diagnostics import ConfigError, ConversionError, memory_full
    from urdf2mbs.files import absolute

    try:
        absolute(Path())  # a working folder that is not there any more is told at once
        code: int = module_of(arguments.command).carry_out(arguments)
        sys.stdout.flush()
        return code
    except ConversionError as error:
        if arguments.debug:
            raise
        print(error, file=sys.stderr)
        if getattr(arguments, "json", False):
            from urdf2mbs.commands.printing import print_json

            print_json(
                {
                    "error": {
                        k: getattr(error, k) for k in ("code", "message", "file", "line", "hint")
                    },
                    "diagnostics": error.said,
                }
            )
        return error.exit_code
    except BrokenPipeError:
        # whoever read our output has seen enough
        _leave_stdout()
        return 0
    except KeyboardInterrupt:
        return 130
    except MemoryError:
        if arguments.debug:
            raise
        print(memory_full("this command"), file=sys.stderr)
        return ConversionError.exit_code
    except Exception as error:
        if arguments.debug:
            raise
        _leave_stdout()
        if isinstance(error, OSError) and error.errno == ENOSPC:
            print(f"error[output-unwritable]: cannot print: {error.strerror}", file=sys.stderr)
            return ConfigError.exit_code
        said = ConversionError(
            "internal", f"{type(error).__name__}: {' '.join(str(error).split())}",
            hint="this is a mistake in urdf2mbs: please report it; --debug shows more",
        )  # fmt: skip
        print(said, file=sys.stderr)
        return said.exit_code


def _stop(signal: int, *_: object) -> None:
    """A process that is asked to end takes away its unfinished files first."""
    raise SystemExit(128 + signal)


def _leave_stdout() -> None:
    from contextlib import suppress

    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
