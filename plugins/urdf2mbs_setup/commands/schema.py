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
from urdf2mbs_setup.commands.explain import print_broken_plugins
from urdf2mbs_setup.options import list_inner_structs

EXAMPLES = ("urdf2mbs schema > config.schema.json",)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_no_plugins(command)
    add_fields(command, "plugins")


def carry_out(arguments: argparse.Namespace) -> int:
    """Print the schema."""
    plugin_files = [Path(file) for file in arguments.plugins]
    plugins = Plugins(plugin_files, installed=not arguments.no_plugins)
    print_broken_plugins(plugins)
    print_json(make_schema(plugins))
    return 0


def make_schema(plugins: Plugins) -> dict[str, Any]:
    """Make the JSON schema (draft 2020-12) of a config that may use the passes of plugins.

    msgspec makes the schema of the class ``Config``.  It does not know the passes, whose names and
    options depend on the plugins::

        of msgspec                          returned
        passes: {type: object}              passes: {properties: {check: {properties: ...}, ...}}
        pipeline: {anyOf: [string, array]}  pipeline: {anyOf: [{enum: [compact, ...]}, array]}
    """
    (_,), definitions = msgspec.json.schema_components([Config], ref_template="#/$defs/{name}")
    for struct_class in (Config, *list_inner_structs(Config)):
        _add_descriptions(struct_class, definitions[struct_class.__name__])
    config_schema = definitions.pop("Config")
    config_schema["title"] = "urdf2mbs config"
    _name_passes(config_schema["properties"], plugins)
    config_schema["properties"]["passes"] |= {
        "properties": _make_options(plugins, definitions),
        "additionalProperties": False,
    }
    _accept_single_words(config_schema)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **config_schema,
        "$defs": dict(sorted(definitions.items())),
    }


def _name_passes(properties: dict[str, Any], plugins: Plugins) -> None:
    """Add the names of passes and presets to the keys of a config that expect them."""
    properties["xacro_args"]["additionalProperties"] = {
        "type": ["string", "number", "boolean"]  # xacro gets the word that the config has
    }
    pass_name = {"enum": sorted(plugins.passes)}
    pass_names = {"type": "array", "items": pass_name}
    properties["pipeline"]["anyOf"] = [{"enum": sorted(plugins.presets)}, pass_names]
    properties["after"]["additionalProperties"] = {"anyOf": [pass_name, pass_names]}
    properties["after"]["propertyNames"] = pass_name
    properties["swap"]["propertyNames"] = pass_name


def _make_options(plugins: Plugins, definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of the options of each pass; their classes go into ``definitions``."""
    option_schemas: dict[str, Any] = {}
    for pass_name, entries in sorted(plugins.passes.items()):
        schemas = [
            _make_pass_schema(
                load_pass(entry),
                pass_name if entry.is_ours else f"{pass_name}.{entry.plugin}",
                definitions,
            )
            for entry in entries
        ]
        # 'swap' says whose pass of this name is used
        option_schemas[pass_name] = schemas[0] if len(schemas) == 1 else {"anyOf": schemas}
        option_schemas[pass_name]["description"] = load_pass(entries[0]).summary()
    return option_schemas


def _make_pass_schema(pass_class: type, prefix: str, definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a pass's options.

    Args:
        pass_class: Class of the pass.
        prefix: Beginning of the names of its classes in ``definitions``.
        definitions: Gets the schemas of the classes in the options.
    """
    (reference,), components = msgspec.json.schema_components(
        [pass_class], ref_template=f"#/$defs/{prefix}.{{name}}"
    )
    inner_structs = {struct.__name__: struct for struct in list_inner_structs(pass_class)}
    for class_name, component in components.items():
        component.pop("title", None)
        definitions[f"{prefix}.{class_name}"] = component
        if class_name in inner_structs:
            _add_descriptions(inner_structs[class_name], component)
    pass_schema = components.get(pass_class.__name__, reference)
    pass_schema["additionalProperties"] = False
    _accept_single_words(pass_schema)
    _add_descriptions(pass_class, pass_schema)
    return reference


def _add_descriptions(struct_class: type, schema: dict[str, Any]) -> None:
    """Add the docstrings of a class's fields to its schema."""
    properties = schema.get("properties", {})
    field_docstrings = field_docs(struct_class)
    for field in msgspec.structs.fields(struct_class):
        property_name, description = field.encode_name, field_docstrings.get(field.name)
        if property_name in properties and description is not None:
            properties[property_name].setdefault("description", description)


def _accept_single_words(schema: dict[str, Any]) -> None:
    """Accept a single word for a list of words."""
    for property_ in schema.get("properties", {}).values():
        if (property_.get("items") or {}).get("type") == "string":
            word_schema = property_.pop("items")
            property_["anyOf"] = [
                word_schema,
                {"type": property_.pop("type"), "items": word_schema},
            ]
