"""The files of equations that a simulation runs: the project's own, else made anew and kept."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path

from urdf2mbs.plugin import ConversionError, temporary_name
from urdf2mbs_equations.equations_fit import fits
from urdf2mbs_equations.options import EquationOptions, Language
from urdf2mbs_simulate.data import MbsData

SUFFIX = {"python": "py", "c": "c"}
#: What Robotran writes at the beginning of its equations, and which files they want.
JOINTS = re.compile(rb"==> Number of joints *: *(\d+)")
INCLUDES = re.compile(rb'(?m)^ *# *include *"([^"]+)"')
HEADERS = Path(__file__).parent / "mbsysc"


class SimulationError(ConversionError, RuntimeError):
    """A project that cannot be simulated; Robotran raises a RuntimeError, and main.py knows it."""


def equations(data: MbsData, names: Iterable[str], language: Language) -> dict[str, Path]:
    """The file of each function.

    A function that the project does not have is made for its model, and kept in ``cache_folder``.
    So is one of Robotran's that cannot run: ``data._run.notes`` tells why.

    Raises ConversionError where equations of the project are of another model.
    """
    found: dict[str, Path] = {}
    for name in names:
        file = data.symbolic_path / _file(data, name, language)
        text = file.read_bytes() if file.is_file() else b""
        why = _cannot_run(data, text)
        if why and why not in data._run.notes:
            data._run.notes.append(why)
        if why or not text:
            found[name] = _made(data, name, language)
            continue
        if fits(text, data._run.source) is False:
            raise ConversionError(
                "equations-of-another-model",
                f"the equations are not of the model '{data._run.file}'", file=str(file),
                hint=f"make them anew: urdf2mbs equations {data._run.file}",
            )  # fmt: skip
        found[name] = file
    return found


def _cannot_run(data: MbsData, text: bytes) -> str | None:
    """Why equations of Robotran's are not used; None of those that are."""
    joints = JOINTS.search(text[:2000])
    if joints and int(joints[1]) != data.njoint:
        return f"not used: equations in symbolicR, of a model with {int(joints[1])} joints"
    for name in map(bytes.decode, INCLUDES.findall(text)):
        if not any((folder / name).is_file() for folder in (data.symbolic_path, HEADERS)):
            return f"not used: equations in symbolicR that want {name} of another Robotran"
    return None


def _file(data: MbsData, name: str, language: Language) -> str:
    return f"mbs_{name}_{data.mbs_name}.{SUFFIX[language]}"


def _made(data: MbsData, name: str, language: Language) -> Path:
    """A file of the cache; it is made if it is not there."""
    from urdf2mbs_equations.files import generate

    key = sha256(b"\0".join([_generator(), data._run.source, language.encode()]))
    file = cache_folder() / "equations" / key.hexdigest()[:32] / _file(data, name, language)
    if not file.is_file():
        made = generate(
            data._run.mbs,
            data._run.source,
            data._run.file.name,
            EquationOptions(language=language),
            [name],
        )
        if name in made.left_out:
            why = made.left_out[name]
            hint = "give mass and inertia to the links that it moves, or let estimate-inertia do so"
            raise ConversionError(
                "equations-not-generated", f"there is no {name}: {why}", file=str(data._run.file),
                hint=hint if why.startswith("no matter") else None,
            )  # fmt: skip
        keep(file, made.files[file.name])
    return file


@cache
def _generator() -> bytes:
    """A checksum of the code that makes equations: what older code has made is not used."""
    import urdf2mbs_equations

    (folder,) = urdf2mbs_equations.__path__
    sources = sorted(path for path in Path(folder).iterdir() if path.is_file())
    return sha256(b"".join(path.read_bytes() for path in sources)).digest()


def cache_folder() -> Path:
    """Where the system keeps what programs can make again."""
    if sys.platform == "win32":
        place = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        place = "~/Library/Caches"
    else:
        place = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(place).expanduser() / "urdf2mbs"


def keep(file: Path, data: bytes) -> None:
    """Write a file of the cache whole or not at all, whoever writes it at the same time."""
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(file)
    temporary.write_bytes(data)
    temporary.replace(file)
