"""The scripts and the data of the page, as texts for its HTML."""

from __future__ import annotations

import gzip
import json
import re
from base64 import b64encode
from importlib.metadata import PackageNotFoundError, distribution
from importlib.resources import files
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import ConfigError

#: The package that brings three.js: a build for SageMath that has OrbitControls, too.  It keeps
#: the file of each revision that it ever had.
THREE_PACKAGE = "jupyter-threejs-sage"
THREE_FILE = "jupyter_threejs_sage/static/r{}/three.min.js"
#: The revisions of three.js with which the page opens without a warning.  Revision 150 warns that
#: this file goes, 152 changes the colours, and 161 has modules only.
THREE_REVISIONS = range(130, 150)
#: The modules of the page's script, each before those that use it.
MODULES = (
    "basics",
    "viewer",
    "roving",
    "kinematics",
    "loops",
    "positions",
    "geometry",
    "scene",
    "shapes",
    "skeleton",
    "masses",
    "marks",
    "stops",
    "arrows",
    "comparison",
    "selection",
    "display",
    "gestures",
    "camera",
    "units",
    "panel",
    "diagram",
    "tables",
    "curves",
    "player",
    "modes",
    "main",
)


class Script(msgspec.Struct):
    """A module of another plugin for a robot that is simulated in the page."""

    text: str
    data: dict[str, Any]
    """The script reads it as ``data.live``."""


def read_resource(file_name: str) -> str:
    """Read a file of this package, without the end of its last line."""
    return files("urdf2mbs_report").joinpath(file_name).read_text("utf-8").rstrip("\n")


def bundle_modules(last_module: str) -> str:
    """Join the page's own modules into one script, since a page on disk can load none.

    All modules share the scope of one asynchronous function, in which ``viewer`` waits for
    three.js; the last module, another plugin's, has a scope of its own.  Import and export
    statements are removed: names are unique in all modules, and ``MODULES`` is in their order.
    ``window.urdf2mbs.ready`` resolves when the page is built.
    """
    modules = [read_resource(f"js/{module_name}.js") for module_name in MODULES]
    bundled_script = "\n\n".join([*modules, f"{{\n{last_module}}}"])
    bundled_script = re.sub(r"^import .*?;\n+", "", bundled_script, flags=re.DOTALL | re.MULTILINE)
    bundled_script = re.sub(r"^export ", "", bundled_script, flags=re.MULTILINE)
    return "\n".join(
        [
            '"use strict";',
            "window.urdf2mbs = {ready: (async () => {",
            bundled_script,
            "await window.urdf2mbs.opened;",
            "})()};",
        ]
    )


def pack_viewer() -> str:
    """Return three.js, gzipped and in base64, which is a third of its size."""
    return b64encode(gzip.compress(find_viewer().read_bytes(), mtime=0)).decode()


def find_viewer() -> Path:
    """Return the file of three.js in the installed package, of the newest revision that fits.

    Raises:
        ConfigError: The package is not installed, or has no revision that fits.
    """
    first, last = THREE_REVISIONS[0], THREE_REVISIONS[-1]
    hint = f"pip install '{THREE_PACKAGE}=={first}'"
    try:
        package = distribution(THREE_PACKAGE)
    except PackageNotFoundError:
        message = f"{THREE_PACKAGE}, which has the viewer three.js, is not installed"
        raise ConfigError("viewer-missing", message, hint=hint) from None
    for revision in reversed(THREE_REVISIONS):
        viewer_file = Path(str(package.locate_file(THREE_FILE.format(revision))))
        if viewer_file.is_file():
            return viewer_file
    message = (
        f"{THREE_PACKAGE} {package.version} has no three.js of revision {first} to {last} "
        f"({THREE_FILE.format('...')})"
    )
    raise ConfigError("viewer-missing", message, hint=hint)


def encode_data(data: Any) -> str:
    """Encode data as JSON in which no name can end the script element."""
    json_text = json.dumps(msgspec.to_builtins(data), ensure_ascii=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        json_text = json_text.replace(character, f"\\u{ord(character):04x}")
    return json_text
