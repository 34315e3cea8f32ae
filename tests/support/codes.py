"""The codes of all errors, warnings and notes, as the files ``codes.py`` list them."""

import ast
import re
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

#: Where a code stands in a text that a test expects: alone, as ``error[code]``, or first.
_EXPECTED = re.compile(r"(?:^|\\?\[)([a-z0-9]+(?:-[a-z0-9]+)*)(?=$|\\?\]|\.\*|: )")
_BRACKETED = re.compile(r"(?:error|warning|note)\\?\[([a-z0-9-]+)")


def list_asserted_codes(module: str) -> set[str]:
    """Return the codes that the tests of a module (its text) assert.

    They stand in an ``assert`` or another comparison, in ``pytest.raises``, in a row of a table, or
    as ``error[code]``.  A single word, which may mean something else, counts only where the code is
    spoken of: in ``assert error.code == "loop"``, or in rows of which one part is ``code``.
    """
    found = set(_BRACKETED.findall(module))
    tree = ast.parse(module)
    tables = {
        ast.unparse(target): node.value
        for node in tree.body
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
    }
    for node in ast.walk(tree):
        where: ast.AST = node
        expected: list[ast.AST] = []
        if isinstance(node, (ast.Assert, ast.Compare)) or _calls(node, "pytest.raises"):
            expected = [*ast.walk(node)]
        elif isinstance(node, (ast.Tuple, ast.List, ast.Set)):
            expected = node.elts
        elif isinstance(node, (ast.Assign, ast.AnnAssign)) and isinstance(node.value, ast.Dict):
            expected = [*ast.walk(node.value)]
        elif isinstance(node, ast.For):
            where, expected = node.target, [*ast.walk(node.iter)]
        elif _calls(node, "pytest.mark.parametrize"):
            where, rows = node.args[:2]
            expected = [*ast.walk(tables.get(ast.unparse(rows), rows))]
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Subscript):
            where, rows = node.targets[0], node.value.value
            expected = [*ast.walk(tables.get(ast.unparse(rows), rows))]
        words = {
            word
            for one in expected
            if isinstance(one, ast.Constant) and isinstance(one.value, str)
            for word in _EXPECTED.findall(one.value)
        }
        found |= {word for word in words if "-" in word}
        if words - found and re.search(r"\bcodes?\b", ast.unparse(where)):
            found |= words
    return found


def _calls(node: ast.AST, function: str) -> bool:
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and ast.unparse(node.func) == function
    )
