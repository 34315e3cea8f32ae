"""The version of urdf2mbs, found without an import that takes longer than Python takes to start."""

from __future__ import annotations

import os
import sys


def find_version() -> str:
    """Return the version of the installed package, which is in the name of its metadata's folder.

    Where no folder has it, as in a zip file, ``importlib.metadata`` finds it: importing that takes
    four times as long as Python takes to start.
    """
    prefix, suffix = "urdf2mbs-", ".dist-info"
    for folder in sys.path:
        try:
            entry_names = os.listdir(folder or ".")  # noqa: PTH208  importing pathlib takes long
        except OSError:
            continue
        for entry_name in entry_names:
            if entry_name.startswith(prefix) and entry_name.endswith(suffix):
                return entry_name[len(prefix) : -len(suffix)]
    from importlib.metadata import version

    return version("urdf2mbs")
