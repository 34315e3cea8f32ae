"""The JSON schema of a config, with every known pass and its options, for editors.

Prints every key, every known pass and its options: an editor completes and
checks a config by them.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    Config,
    Plugins,
    add_fields,
    add_no_plugins,
    field_docs,
    load_pass,
    print_json,
)
from urdf2mbs_setup.commands.explain import warn_of
from urdf2mbs_setup.options import inner_structs

EXAMPLES = ("urdf2mbs schema > config.schema.json",)


def add_options(command: argparse.ArgumentParser) -> None:
    add_no_plugins(command)
    add_fields(command, "plugins")


def carry_out(arguments: argparse.Namespace) -> int:
    files = [Path(file) for file in arguments.plugins]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    warn_of(plugins)
    print_json(schema(plugins))
    return 0


def schema(plugins: Plugins) -> dict[str, Any]:
    """A JSON schema (draft 2020-12) of a config that may use these plugins' passes."""
    (_,), defs = msgspec.json.schema_components([Config], ref_template="#/$defs/{name}")
    for kind in (Config, *inner_structs(Config)):
        _describe(kind, defs[kind.__name__])
    config = defs.pop("Config")
    config["title"] = "urdf2mbs config"
    properties = config["properties"]
    properties["xacro_args"]["additionalProperties"] = {
        "type": ["string", "number", "boolean"]  # each is the word as it is written
    }
    names = {"enum": sorted(plugins.passes)}
    listed = {"type": "array", "items": names}
    properties["pipeline"]["anyOf"] = [{"enum": sorted(plugins.presets)}, listed]
    properties["after"]["additionalProperties"] = {"anyOf": [names, listed]}
    properties["after"]["propertyNames"] = names
    properties["swap"]["propertyNames"] = names

    options: dict[str, Any] = {}
    for name, offered in sorted(plugins.passes.items()):
        # which plugin's options hold is said by 'swap'
        found = [
            _options(load_pass(entry), name if entry.is_ours else f"{name}.{entry.plugin}", defs)
            for entry in offered
        ]
        options[name] = found[0] if len(found) == 1 else {"anyOf": found}
        options[name]["description"] = load_pass(offered[0]).summary()
    properties["passes"] |= {"properties": options, "additionalProperties": False}
    _accept_one_word(config)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **config,
        "$defs": dict(sorted(defs.items())),
    }


def _options(kind: type, prefix: str, defs: dict[str, Any]) -> dict[str, Any]:
    """The schema of a pass's options; the classes in it go into ``defs``."""
    (reference,), components = msgspec.json.schema_components(
        [kind], ref_template=f"#/$defs/{prefix}.{{name}}"
    )
    inner = {struct.__name__: struct for struct in inner_structs(kind)}
    for name, component in components.items():
        component.pop("title", None)
        defs[f"{prefix}.{name}"] = component
        if name in inner:
            _describe(inner[name], component)
    top = components.get(kind.__name__, reference)
    top["additionalProperties"] = False
    _accept_one_word(top)
    _describe(kind, top)
    return reference


def _describe(kind: type, component: dict[str, Any]) -> None:
    """Put the docstrings of a class's fields into its schema."""
    properties = component.get("properties", {})
    docs = field_docs(kind)
    for field in msgspec.structs.fields(kind):
        name, text = field.encode_name, docs.get(field.name)
        if name in properties and text is not None:
            properties[name].setdefault("description", text)


def _accept_one_word(component: dict[str, Any]) -> None:
    """A single word where a list of words is wanted is a list of one."""
    for one in component.get("properties", {}).values():
        if (one.get("items") or {}).get("type") == "string":
            word = one.pop("items")
            one["anyOf"] = [word, {"type": one.pop("type"), "items": word}]
