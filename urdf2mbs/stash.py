"""A typed place for what a plugin wants to keep on a conversion, from one of its passes to another.

The idea is that of pytest's ``Stash``: only who has the key gets at the value.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, TypeVar, cast

T = TypeVar("T")


class Key(Generic[T]):
    """The key to one value of type ``T``; ``name`` is how a dump calls it."""

    def __init__(self, name: str) -> None:
        self.name = name


class Stash:
    """Values by their keys."""

    def __init__(self) -> None:
        self._values: dict[Key[Any], Any] = {}

    def __setitem__(self, key: Key[T], value: T) -> None:
        self._values[key] = value

    def __getitem__(self, key: Key[T]) -> T:
        """Raises KeyError where nothing was put."""
        if key not in self._values:
            raise KeyError(f"nothing is stashed under '{key.name}'")
        return cast("T", self._values[key])

    def get(self, key: Key[T], default: T) -> T:
        return cast("T", self._values.get(key, default))

    def __contains__(self, key: Key[Any]) -> bool:
        return key in self._values

    def items(self) -> Iterator[tuple[str, Any]]:
        """Names and values, for a dump."""
        return ((key.name, value) for key, value in self._values.items())
