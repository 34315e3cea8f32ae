"""Commands in a process of their own."""

import subprocess
import sys
from pathlib import Path


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words],
        check=False,
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=120,
    )


#: Prints what a program has imported, after it.
MODULES = "import sys, contextlib\nwith contextlib.suppress(SystemExit):\n  {}\nprint(*sys.modules)"


def loaded(program: str) -> set[str]:
    code = MODULES.format(program)
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return set(done.stdout.splitlines()[-1].split())
