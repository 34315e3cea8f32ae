"""The command line ``urdf2mbs``.

Python may look for modules in the working folder, which may be a stranger's.  So this file and
``machine.stopping`` import nothing but modules that every Python has loaded already.
"""

import os
import sys

from urdf2mbs.machine import stopping


def main(argv: list[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same).

    Without ``argv`` the process is ours: then signals end it, and Python looks for no module in
    the working folder.
    """
    if argv is None:
        stopping.end_on_signals()
        _leave_working_folder()
    from urdf2mbs.commands import carry_out

    return carry_out(sys.argv[1:] if argv is None else argv)


def _leave_working_folder() -> None:
    """Take the working folder out of ``sys.path``.

    Python puts it there for ``python -m``, and for each empty entry of PYTHONPATH
    (``PYTHONPATH=$PYTHONPATH:...``).  It stays where PYTHONPATH names it in full.
    """
    try:
        folder = os.getcwd()  # noqa: PTH109
    except OSError:  # the folder is gone, and no module can be in it
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
