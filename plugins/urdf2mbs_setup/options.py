"""The options of a pass for people: types in words, defaults and help."""

from __future__ import annotations

import json
import typing
from typing import Annotated, Any, Literal, get_args, get_origin

import msgspec

from urdf2mbs.plugin import field_docs


class Option(msgspec.Struct):
    """An option of a pass, or a key of an object in its options."""

    name: str
    type: str
    """In words, such as ``list[str]``."""
    required: bool
    default: Any
    """None if the option is required."""
    help: str

    @property
    def default_in_words(self) -> str:
        """The default as a config writes it."""
        if self.default is None:
            return "none"
        if isinstance(self.default, str):
            return self.default or "''"
        return json.dumps(msgspec.to_builtins(self.default))


def list_options(struct_class: type) -> list[Option]:
    """List the options of a pass, or the keys of a struct in its options."""
    field_docstrings, type_hints = field_docs(struct_class), typing.get_type_hints(struct_class)
    options = []
    for field in msgspec.structs.fields(struct_class):
        default = field.default
        if field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        options.append(
            Option(
                name=field.encode_name,
                type=describe_type(type_hints[field.name]),
                required=field.required,
                default=None if default is msgspec.NODEFAULT else default,
                help=field_docstrings.get(field.name, ""),
            )
        )
    return options


def describe_type(type_hint: Any) -> str:
    """Describe a type in words, such as ``float``, ``list[str]`` or ``python | c``."""
    origin, arguments = get_origin(type_hint), get_args(type_hint)
    if origin is Annotated:
        return describe_type(arguments[0])
    if origin is Literal:
        return " | ".join(map(str, arguments))
    if type_hint is type(None):
        return "none"
    if origin is None:
        return str(getattr(type_hint, "__name__", type_hint))
    inner_types = [
        "..." if argument is Ellipsis else describe_type(argument) for argument in arguments
    ]
    if origin in (list, dict, tuple):
        return f"{origin.__name__}[{', '.join(inner_types)}]"
    return " | ".join(dict.fromkeys(inner_types))


def list_inner_structs(struct_class: type) -> list[type]:
    """List the classes of objects in the options of a pass, without the pass itself."""
    inner_structs: list[type] = []
    remaining = list(typing.get_type_hints(struct_class).values())
    while remaining:
        type_hint = remaining.pop()
        remaining += get_args(type_hint)
        if (
            isinstance(type_hint, type)
            and issubclass(type_hint, msgspec.Struct)
            and type_hint not in inner_structs
        ):
            inner_structs.append(type_hint)
            remaining += typing.get_type_hints(type_hint).values()
    return inner_structs
