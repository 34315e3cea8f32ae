"""The command line: reads its words, carries the command out, and says what went wrong."""

import os
import sys

from urdf2mbs.machine import stopping

# What more a command needs is imported when it runs, so that help comes at once.
TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence


def main(argv: "Sequence[str] | None" = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same).

    Without ``argv`` the process is ours: then signals end it, and Python looks for no module in
    the working folder.
    """
    if argv is None:
        stopping.end_on_signals()
        _leave_working_folder()
        _collect_seldom()
    from urdf2mbs.commands import parse

    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed, as for a service: nobody reads it
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # a robot's name may have letters that this terminal or pipe has not
            reconfigure(errors="backslashreplace")
    return _run(parse(sys.argv[1:] if argv is None else argv))


def _leave_working_folder() -> None:
    """Take the working folder out of ``sys.path``: it may be a stranger's.

    Python puts it there for ``python -m``, and for each empty entry of PYTHONPATH
    (``PYTHONPATH=$PYTHONPATH:...``).  It stays where PYTHONPATH names it in full.
    """
    try:
        folder = os.getcwd()  # noqa: PTH109
    except OSError:  # it is not there any more, nor is anything in it
        return
    named = [
        os.path.abspath(place)  # noqa: PTH100
        for place in os.environ.get("PYTHONPATH", "").split(os.pathsep)
        if os.path.isabs(place)  # noqa: PTH117
    ]
    library = os.path.dirname(os.__file__)  # noqa: PTH120
    # behind Python's own library stands what is installed, perhaps from the working folder
    before = sys.path.index(library) if library in sys.path else len(sys.path)
    if folder not in named:
        sys.path[:before] = [place for place in sys.path[:before] if place not in ("", folder)]


def _collect_seldom() -> None:
    """Let Python look for garbage seldom, and not when the process ends.

    Together a tenth of the time that the conversion of NAO takes as a process.
    """
    import atexit
    import gc

    gc.set_threshold(500_000, 20, 100)
    atexit.register(gc.freeze)


def _run(arguments: "argparse.Namespace") -> int:
    from urdf2mbs.commands.colours import shown
    from urdf2mbs.commands.streams import quiet

    with shown(arguments.color), quiet(getattr(arguments, "quiet", False)):
        return _carry_out(arguments)


def _carry_out(arguments: "argparse.Namespace") -> int:
    from errno import ENOSPC
    from pathlib import Path

    from urdf2mbs.disk.files import absolute
    from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, memory_full

    try:
        absolute(Path())  # a working folder that is not there any more is told at once
        from urdf2mbs.commands import module_of

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
        print(stopping.line(stopping.SIGINT), file=sys.stderr)
        return 128 + stopping.SIGINT
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


def _leave_stdout() -> None:
    from contextlib import suppress

    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
