"""The parser for XML files that may come from anywhere."""

from __future__ import annotations

from typing import Any

from lxml import etree


def safe_parser(**options: Any) -> etree.XMLParser:
    """A parser that reads nothing but the text."""
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, **options)
