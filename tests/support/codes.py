"""The codes of all errors, warnings and notes, as the files ``codes.py`` list them."""

from importlib import import_module
from importlib.util import find_spec

from support.folders import ROOT
from urdf2mbs.engine.plugins import Plugins

#: The codes of the plugins that are there: one may be hidden, and with it those that need it.
_HERE = Plugins(installed=False).codes.keys()


def is_here(package: str) -> bool:
    try:
        return find_spec(package) is not None
    except ModuleNotFoundError:
        return False


#: What ``codes.py`` of each room and plugin says, by the name of the folder.
TABLES: dict[str, dict[str, str]] = {
    file.parent.name: import_module(f"{package}{file.parent.name}.codes").CODES
    for folder, package in (("urdf2mbs", "urdf2mbs."), ("plugins", ""))
    for file in (ROOT / folder).glob("*/codes.py")
    if is_here(f"{package}{file.parent.name}")
}
TABLES = {
    name: table
    for name, table in TABLES.items()
    if not name.startswith("urdf2mbs_") or table.keys() <= _HERE
}

#: The level and meaning of each code.
CATALOGUE = {code: text for table in TABLES.values() for code, text in table.items()}

#: The codes whose level a user can change, with their level.
DEFAULTS = {
    code: text.partition(":")[0].removesuffix(", unless lowered")
    for code, text in CATALOGUE.items()
    if not text.startswith("error:")
}
