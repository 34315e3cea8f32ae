"""Run MuJoCo's compiler in a process of its own, in an empty folder, for a limited time.

A crash of MuJoCo ends that process, and not ours; the files that it writes go with the folder.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec

from urdf2mbs.plugin import ConversionError, not_installed
from urdf2mbs_mjcf.fields import LOST, LOST_OPTIONS, PLUGINS
from urdf2mbs_mjcf.model import KINDS, Compiled, list_fields

#: The time of a compilation (s); the largest model known takes 6 s.
MAX_SECONDS = 60
#: The memory of the process (bytes), and the largest file that it writes.
MAX_MEMORY, MAX_FILE = 8 * 2**30, 2**30
_SCRIPT = Path(__file__).with_name("compiler.py")
_LINE = re.compile(r"line (\d+)")


def compile_mjcf(source: Path) -> Compiled:
    """Return what MuJoCo makes of an MJCF, whose files have been checked.

    Raises:
        ConfigError: ``extra-missing``, MuJoCo is not installed.
        ConversionError: ``mjcf-invalid``, ``mjcf-crash`` or ``mjcf-too-large``.
    """
    if find_spec("mujoco") is None:
        error = not_installed("an MJCF", "mujoco")
        error.hint = "pip install 'urdf2mbs[mjcf]'"
        raise error
    with TemporaryDirectory(prefix="urdf2mbs-mjcf-") as folder:
        result = Path(folder, "result.json")
        process = _run(source, folder, result)
        content = result.read_bytes() if process.returncode == 0 and result.is_file() else b""
    if not content:
        raise _explain_crash(process, source)
    if content.startswith(b'{"error"'):
        raise _explain_error(json.loads(content)["error"], source)
    # before MuJoCo 4, what is true or false is a number
    return msgspec.json.decode(content, type=Compiled, strict=False)


def _run(source: Path, folder: str, result: Path) -> subprocess.CompletedProcess[bytes]:
    """Run the compiler in a folder."""
    job: dict[str, Any] = {
        "source": str(source),
        "result": str(result),
        "path": sys.path,
        "seconds": MAX_SECONDS,
        "memory": MAX_MEMORY,
        "file_size": MAX_FILE,
        "kinds": {
            kind: (prefix, object_type, list_fields(kind))
            for kind, (prefix, object_type, _) in KINDS.items()
        },
        "lost": {**dict.fromkeys(LOST, 0), **dict.fromkeys(PLUGINS, -1)},
        "lost_options": list(LOST_OPTIONS),
    }
    try:
        return subprocess.run(
            [sys.executable, "-I", "-S", str(_SCRIPT)],
            input=json.dumps(job).encode(),
            capture_output=True,
            cwd=folder,
            timeout=MAX_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        message = f"MuJoCo takes more than {MAX_SECONDS} s to compile it"
        raise ConversionError("mjcf-too-large", message, file=str(source)) from None


def _explain_crash(process: subprocess.CompletedProcess[bytes], source: Path) -> ConversionError:
    """Return the error for a process that has left no result."""
    if process.returncode == -getattr(signal, "SIGXCPU", 0):
        message = f"MuJoCo takes more than {MAX_SECONDS} s to compile it"
        return ConversionError("mjcf-too-large", message, file=str(source))
    last_line = (process.stderr.decode("utf-8", "replace").strip().splitlines() or [""])[-1]
    if "MemoryError" in last_line or "allocate memory" in last_line:
        message = f"MuJoCo takes more than {MAX_MEMORY >> 30} GiB of memory to compile it"
        return ConversionError("mjcf-too-large", message, file=str(source))
    reason = last_line or f"exit code {process.returncode}"
    if process.returncode < 0:
        reason = signal.strsignal(-process.returncode) or f"signal {-process.returncode}"
    hint = "does it load in MuJoCo? python -m mujoco.viewer --mjcf=FILE"
    message = f"MuJoCo has crashed on it: {reason}"
    return ConversionError("mjcf-crash", message, file=str(source), hint=hint)


def _explain_error(text: str, source: Path) -> ConversionError:
    """Return the error for what MuJoCo says, at its line."""
    words = " ".join(text.split())
    line_match = _LINE.search(words)
    line = int(line_match[1]) if line_match else None
    message = f"MuJoCo does not read it: {words}"
    return ConversionError("mjcf-invalid", message, file=str(source), line=line)
