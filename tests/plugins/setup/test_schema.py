"""The schema of a config knows what the reader of a config knows."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from support.folders import ROOT
from urdf2mbs.config.load import parse
from urdf2mbs.config.model import Config
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs_setup.commands.schema import make_schema

FILE = Path("robot.yaml")


#: The codes of what a schema can see.
SEEN = {"config-type", "unknown-key", "value-range", "unknown-pass", "unknown-preset"}


def good(text: str, schema: dict[str, Any]) -> bool:
    return Draft202012Validator(schema).is_valid(yaml.safe_load(text))


@pytest.fixture(scope="module")
def ours() -> dict[str, Any]:
    return make_schema(Plugins(installed=False))


@pytest.mark.parametrize("file", sorted((ROOT / "configs").glob("*.yaml")), ids=lambda f: f.name)
def test_our_configs_agree_with_it(file: Path, ours: dict[str, Any]) -> None:
    assert good(file.read_text(), ours)


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("output: {project: x}", True),
        ("output: {project: ''}", False),
        ("output: {project: x, more: 1}", False),
        ("outptu: x", False),
        ("base: flying", False),
        ("gravity: [0, 0, 1.0e+300]", False),
        ("passes: {check: {tolerance: 1.0e-6}}", True),
        ("passes: {check: {tolerance: 0.8}}", False),
        ("xacro_args: {a: 1, b: true, c: x}", True),
        ("plugins: [a.py, 1]", False),
        ("pipeline: faithless", False),
        ("pipeline: [expand, emit]", True),
        ("pipeline: [expand, emitt]", False),
        ("after: {expand: [check]}", True),
        ("after: {xpand: check}", False),
        ("swap: {emitt: mine}", False),
        ("passes: {prune-massless: {keep: '*'}}", True),
        ("passes: {prune-massless: {keep: ['a', 'b']}}", True),
        ("passes: {prune-massless: {kep: '*'}}", False),
        ("passes: {prune: {}}", False),
    ],
)
def test_the_schema_and_the_reader_know_good_from_bad(
    text: str, right: bool, ours: dict[str, Any]
) -> None:
    assert good(f"source: x\n{text}", ours) == right
    assert not good(text, ours), "there is no source"
    try:
        Pipeline(*parse(f"source: x\n{text}", FILE), installed_plugins=False)
        read = True
    except ConfigError as error:
        read = error.code not in SEEN
    assert read == right


def test_every_key_of_a_config_is_described(ours: dict[str, Any]) -> None:
    assert set(ours["properties"]) == set(Config.__struct_fields__)
    assert all(property_schema["description"] for property_schema in ours["properties"].values())
    for name, definition in ours["$defs"].items():
        if "." in name:  # of a pass
            for field, property_schema in definition.get("properties", {}).items():
                assert property_schema.get("description"), f"{name}.{field} has no docstring"


def test_a_plugins_options_are_in_the_schema() -> None:
    schema = make_schema(Plugins([ROOT / "tests" / "door" / "rename_links.py"], installed=False))
    text = "source: x\nafter: {expand: rename-links}\npasses: {rename-links: {links: {a: b}}}"
    assert good(text, schema)
    assert not good(text.replace("a: b", "a: 1"), schema)
    assert not good(text.replace("{links", "{lnks"), schema)
    rules = schema["$defs"]["rename-links.rename_links.RenameLinks"]["properties"]
    assert rules["links"]["description"] == "The new name of each link that gets one."
