"""YAML files of a robot: values, of a limited number and depth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import yaml

from urdf2mbs_xacro.limits import MAX_LENGTH, too_large

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

#: The levels of lists in a file, even of a trusted one: PyYAML's C code calls itself for each.
MAX_DEPTH = 100


def load_yaml(
    data: bytes, name: str, constructors: Mapping[str, Callable[..., Any]], trust: bool
) -> Any:
    """Return the values of a YAML text.

    Args:
        data: The text.
        name: The name of its file, for messages.
        constructors: The functions that construct the value of each tag, such as ``!degrees``.
        trust: Whether the number of values is unlimited.

    Raises:
        ConversionError: ``xacro-too-large``.
        yaml.YAMLError: The text is not YAML.
    """

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        """A loader of this expansion alone: xacro adds its tags to the loader of the process."""

    for tag, constructor in constructors.items():
        Loader.add_constructor(tag, constructor)
    _check_events(data, name, Loader, trust)
    loader = Loader(data)
    root_node = loader.get_single_node()
    if root_node is None:
        return None
    if not trust and _count_nodes(root_node, {}) > MAX_LENGTH:
        raise too_large(f"'{name}' has more than {MAX_LENGTH:,} values")
    return loader.construct_document(root_node)


def _check_events(yaml_bytes: bytes, file_name: str, loader: type[Any], trust: bool) -> None:
    """Raise ConversionError for a text that is nested too deep, or has too many values."""
    nesting_depth = 0
    for event_index, event in enumerate(yaml.parse(yaml_bytes, loader)):
        nesting_depth += isinstance(event, yaml.CollectionStartEvent)
        nesting_depth -= isinstance(event, yaml.CollectionEndEvent)
        if nesting_depth > MAX_DEPTH:
            raise too_large(f"'{file_name}' has lists nested more than {MAX_DEPTH} levels deep")
        if event_index > 2 * MAX_LENGTH and not trust:
            raise too_large(f"'{file_name}' has more than {MAX_LENGTH:,} values")


def _count_nodes(node: Any, counts: dict[int, int]) -> int:
    """Return the nodes of a YAML text, each as often as an alias or a merge repeats it."""
    if id(node) not in counts:
        counts[id(node)] = MAX_LENGTH  # of a node that contains itself
        child_nodes = node.value if isinstance(node.value, list) else ()
        node_groups = (
            child_node if isinstance(child_node, tuple) else (child_node,)
            for child_node in child_nodes
        )
        counts[id(node)] = 1 + sum(
            _count_nodes(child_node, counts)
            for node_group in node_groups
            for child_node in node_group
        )
    return counts[id(node)]
