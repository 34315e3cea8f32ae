"""The scripts and the data of the page, as texts for its HTML."""

from __future__ import annotations

import json
import re
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import ConfigError

#: The package that brings three.js, and its file in the package.
THREE_PACKAGE = "jupyter-threejs-sage"
THREE_FILE = "jupyter_threejs_sage/static/r130/three.min.js"
#: The modules of the page's script, each before those that use it.
MODULES = (
    "basics",
    "kinematics",
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
    "camera",
    "panel",
    "diagram",
    "player",
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

    All modules share one scope, but for the last one, another plugin's.  Import and export
    statements are removed: names are unique in all modules, and ``MODULES`` is in their order.
    """
    modules = [read_resource(f"js/{module_name}.js") for module_name in MODULES]
    bundled_script = "\n\n".join([*modules, f"{{\n{last_module}}}"])
    bundled_script = re.sub(r"^import .*?;\n+", "", bundled_script, flags=re.DOTALL | re.MULTILINE)
    bundled_script = re.sub(r"^export ", "", bundled_script, flags=re.MULTILINE)
    return f'"use strict";\n(() => {{\n{bundled_script}\n}})();'


def read_viewer() -> str:
    """Read three.js; raise ConfigError if the installed package does not have it."""
    package = distribution(THREE_PACKAGE)
    try:
        return Path(str(package.locate_file(THREE_FILE))).read_text("utf-8")
    except OSError:
        message = f"the installed {THREE_PACKAGE} does not have {THREE_FILE}"
        hint = f"pip install {THREE_PACKAGE}==130"
        raise ConfigError("viewer-missing", message, hint=hint) from None


def escape_script(script_text: str) -> str:
    """Escape what would end the script element of a script."""
    script_text = re.sub(r"</(script)", r"<\\/\1", script_text, flags=re.IGNORECASE)
    return script_text.replace("<!--", "<\\!--")


def encode_data(data: Any) -> str:
    """Encode data as JSON in which no name can end the script element."""
    json_text = json.dumps(msgspec.to_builtins(data), ensure_ascii=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        json_text = json_text.replace(character, f"\\u{ord(character):04x}")
    return json_text
