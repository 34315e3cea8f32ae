"""Write the plugins of tests/door into docs/passes.md: python docs/make_examples.py."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "passes.md"


def show_examples(page: str) -> str:
    """Return a page in which each block of a plugin of tests/door has the text of its file."""

    def show(block: re.Match[str]) -> str:
        file = ROOT / "tests" / "door" / block["file"]
        text = file.read_text(encoding="utf-8") if file.is_file() else block["text"]
        return f"```python file={block['file']}\n{text}```"

    block = r"(?sm)^```python file=(?P<file>[\w.]+)\n(?P<text>.*?)^```"
    return re.sub(block, show, page)


if __name__ == "__main__":
    PAGE.write_text(show_examples(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
