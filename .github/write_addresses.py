"""Write the addresses of a repository into pyproject.toml and README.md, before a release is built.

    python .github/write_addresses.py https://github.com/OWNER/NAME https://PAGES/ v1.2.3

No file of the repository knows where it lies.  On PyPI there is no folder beside the README, so its
links and pictures get the address of the tag.
"""

import re
import sys
from pathlib import Path


def main(repository: str, pages: str, tag: str) -> None:
    """Change both files in the current folder."""
    addresses = {
        "Homepage": repository,
        "Documentation": pages,
        "Source": repository,
        "Issues": f"{repository}/issues",
        "Changelog": f"{repository}/blob/{tag}/CHANGELOG.md",
    }
    table = "[project.urls]\n"
    lines = "".join(f'{name} = "{address}"\n' for name, address in addresses.items())
    project = Path("pyproject.toml")
    text = project.read_text("utf-8")
    if table not in text:
        sys.exit(f"pyproject.toml has no table {table}")
    project.write_text(text.replace(table, table + lines), "utf-8")

    def link(found: re.Match[str]) -> str:
        kind = "raw" if found[1].startswith("!") else "blob"
        return f"{found[1]}{repository}/{kind}/{tag}/{found[2]}"

    readme = Path("README.md")
    relative = r"(!?\[[^\]]*\]\()(?![a-z]+:|#)([^)]+\))"
    readme.write_text(re.sub(relative, link, readme.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
