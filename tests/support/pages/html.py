"""A page as a parser sees it."""

import json
from typing import Any

from lxml.html import HTMLParser, document_fromstring


class Html:
    """A page: its elements with their attributes, its data, its style, and the text one sees."""

    def __init__(self, text: bytes) -> None:
        parser = HTMLParser(encoding="utf-8", huge_tree=True)
        page: Any = document_fromstring(text, parser=parser)
        self.elements = [(element.tag, dict(element.attrib)) for element in page.iter("*")]
        self.island: Any = json.loads(page.get_element_by_id("data").text)
        self.style = "".join(page.xpath("//style/text()"))
        self.visible = " ".join(page.xpath("//text()[not(parent::script or parent::style)]"))
