"""Write the stub of the door for plugins, urdf2mbs/plugin.pyi: python docs/make_stub.py."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STUB = ROOT / "urdf2mbs" / "plugin.pyi"


def make_stub() -> str:
    """Return the text of the stub, by which a type checker finds each name of the door."""
    from urdf2mbs import plugin

    imports = []
    for name, module in plugin.MODULES.items():
        package, _, last = f"urdf2mbs.{module}".rpartition(".")
        imports.append(f"from {package} import {last} as {name}\n")
    for name, (module, original) in plugin.PLACES.items():
        imports.append(f"from {module} import {original} as {name}\n")
    names = "".join(f'    "{name}",\n' for name in sorted(plugin.__all__))
    return f"{''.join(sorted(imports))}\nVERSION: int\n__all__ = [\n{names}]\n"


if __name__ == "__main__":
    STUB.write_text(make_stub(), encoding="utf-8")
    for words in (["check", "--fix", "--quiet"], ["format", "--quiet"]):
        subprocess.run([sys.executable, "-m", "ruff", *words, str(STUB)], check=True)
