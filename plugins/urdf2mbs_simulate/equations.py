"""The files of equations that a simulation uses: the project's, or generated ones of the cache."""

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
#: What Robotran writes at the beginning of its equations.
JOINT_COUNT = re.compile(rb"==> Number of joints *: *(\d+)")
INCLUDES = re.compile(rb'(?m)^ *# *include *"([^"]+)"')
#: The folder of the headers of MBsysC.
HEADERS = Path(__file__).parent / "mbsysc"


class SimulationError(ConversionError, RuntimeError):
    """A project that cannot be simulated.

    Robotran raises a RuntimeError, which a project's main.py may catch.
    """


def find_equations(data: MbsData, names: Iterable[str], language: Language) -> dict[str, Path]:
    """Find the file of each function of the equations.

    A function that the project does not have is generated for its model, in the cache.  So is one
    of Robotran's that cannot run; ``data._run.notes`` says why.

    Args:
        data: The model.
        names: Of the functions, without ``mbs_``.
        language: ``python`` or ``c``.

    Raises:
        ConversionError: Equations of the project are those of another model.
    """
    files: dict[str, Path] = {}
    for name in names:
        file = data.symbolic_path / _file_name(data, name, language)
        text = file.read_bytes() if file.is_file() else b""
        defect = _find_defect(data, text)
        if defect and defect not in data._run.notes:
            data._run.notes.append(defect)
        if defect or not text:
            files[name] = _generate(data, name, language)
            continue
        if fits(text, data._run.source) is False:
            raise ConversionError(
                "equations-of-another-model",
                f"the equations are not of the model '{data._run.file}'",
                file=str(file),
                hint=f"make them anew: urdf2mbs equations {data._run.file}",
            )
        files[name] = file
    return files


def _find_defect(data: MbsData, text: bytes) -> str | None:
    """Return why equations of Robotran cannot be used; None if they can."""
    joints = JOINT_COUNT.search(text[:2000])
    if joints and int(joints[1]) != data.njoint:
        return f"not used: equations in symbolicR, of a model with {int(joints[1])} joints"
    for name in map(bytes.decode, INCLUDES.findall(text)):
        if not any((folder / name).is_file() for folder in (data.symbolic_path, HEADERS)):
            return f"not used: equations in symbolicR that include {name} of another Robotran"
    return None


def _file_name(data: MbsData, name: str, language: Language) -> str:
    return f"mbs_{name}_{data.mbs_name}.{SUFFIX[language]}"


def _generate(data: MbsData, name: str, language: Language) -> Path:
    """Return the file of a function in the cache, which is generated if it does not exist."""
    from urdf2mbs_equations.files import generate

    key = sha256(b"\0".join([_hash_generator(), data._run.source, language.encode()]))
    folder = get_cache_folder() / "equations" / key.hexdigest()[:32]
    file = folder / _file_name(data, name, language)
    if not file.is_file():
        generated = generate(
            data._run.mbs,
            data._run.source,
            data._run.file.name,
            EquationOptions(language=language),
            [name],
        )
        if name in generated.left_out:
            reason = generated.left_out[name]
            hint = "give mass and inertia to the links that it moves, or let estimate-inertia do so"
            raise ConversionError(
                "equations-not-generated",
                f"there is no {name}: {reason}",
                file=str(data._run.file),
                hint=hint if reason.startswith("no matter") else None,
            )
        write_to_cache(file, generated.files[file.name])
    return file


@cache
def _hash_generator() -> bytes:
    """Return a hash of the code that generates equations: results of older code are not used."""
    import urdf2mbs_equations

    (folder,) = urdf2mbs_equations.__path__
    sources = sorted(path for path in Path(folder).iterdir() if path.is_file())
    return sha256(b"".join(path.read_bytes() for path in sources)).digest()


def get_cache_folder() -> Path:
    """Return the folder of this user for files that programs can make again."""
    if sys.platform == "win32":
        parent = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        parent = "~/Library/Caches"
    else:
        parent = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(parent).expanduser() / "urdf2mbs"


def write_to_cache(file: Path, data: bytes) -> None:
    """Write a file of the cache atomically: another process may write it at the same time."""
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(file)
    temporary.write_bytes(data)
    temporary.replace(file)
