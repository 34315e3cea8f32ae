"""Text of C: the inside of functions, comments, numbers and arrays."""

from __future__ import annotations

import re
from collections.abc import Iterable

from urdf2mbs.plugin import quoted

#: The variables that a function may use: each is declared if a statement names it.
DECLARATIONS = {
    "user_model": "const UserModel *user_model = mbs_data->user_model;",
    **{name: f"double *{name} = mbs_data->{name};" for name in ("q", "qd", "qdd", "q0", "Qq")},
}


def format_body(parameters: str, statements: Iterable[str]) -> str:
    """Return the inside of a function.

    Args:
        parameters: The names of its parameters; those that are not used are cast to void.
        statements: Its statements, which need not declare ``DECLARATIONS``.
    """
    text = "".join(f"{indent(statement)}\n" for statement in statements)
    code = re.sub(r'"[^"]*"', "", text)
    used = set(re.findall(r"(?<![.>])\b\w+", code))  # but not the members of structs
    declarations = "".join(
        f"    {declaration}\n" for name, declaration in DECLARATIONS.items() if name in used
    )
    used |= set(re.findall(r"\w+", declarations))
    unused = "".join(f"    (void) {name};\n" for name in parameters.split() if name not in used)
    return declarations + ("\n" if declarations else "") + unused + text


def indent(text: str) -> str:
    """Indent each line that is not empty by four blanks."""
    return re.sub(r"(?m)^(?=.)", "    ", text)


def format_term(number: float, factor: str = "") -> str:
    """Return a number, with its sign and a factor, as a term of a sum; nothing for zero."""
    return f" {'-' if number < 0.0 else '+'} {abs(number)!r}{factor}" if number else ""


def format_numbers(numbers: Iterable[float]) -> str:
    """Return numbers with commas between them, without negative zeros."""
    return ", ".join(repr(number + 0.0) for number in numbers)


def format_array(kind: str, name: str, elements: Iterable[str]) -> str:
    """Return the definition of a static array, with an element on each line."""
    lines = "".join(f"    {element},\n" for element in elements)
    return f"static const {kind} {name}[] = {{\n{lines}}};\n\n"


def escape_comment(text: str) -> str:
    """Return text in which a comment neither begins nor ends."""
    return quoted(text).replace("*/", "* /").replace("/*", "/ *")
