"""Write the plugins of tests/door into the pages of docs: python docs/make_examples.py."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "docs" / name for name in ("write-a-pass.md", "hooks.md")]


def show_examples(page: str) -> str:
    """Return a page in which each block of a plugin of tests/door has the text of its file."""

    def show(block: re.Match[str]) -> str:
        file = ROOT / "tests" / "door" / block["file"]
        text = file.read_text(encoding="utf-8") if file.is_file() else block["text"]
        return f"```python file={block['file']}\n{text}```"

    block = r"(?sm)^```python file=(?P<file>[\w.]+)\n(?P<text>.*?)^```"
    return re.sub(block, show, page)


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(show_examples(page.read_text(encoding="utf-8")), encoding="utf-8")
