"""Certificates, and the program that replays them."""

import json
from pathlib import Path
from typing import Any

from urdf2mbs import Result, convert
from urdf2mbs_certificate import certificate as checker

ALWAYS = {"certificate": {"write": "always"}}


FILES = ("robot.urdf", "model.mbs", "model.proof.json")


class ReplayOutput:
    """The exit code and the output of a replay."""

    def __init__(self, code: int, out: str, error: str) -> None:
        self.code, self.out, self.error = code, out, error
        self.plain = out == "the same robot\n"


def replay(urdf: bytes, mbs: bytes, certificate: Any, folder: Path, capsys: Any) -> ReplayOutput:
    files = [folder / name for name in FILES]
    text = certificate if isinstance(certificate, str) else json.dumps(certificate)
    for file, data in zip(files, (urdf, mbs, text.encode()), strict=True):
        file.write_bytes(data)
    capsys.readouterr()
    code = checker.main([str(file) for file in files])
    out = capsys.readouterr()
    assert out.err.count("\n") == (code == 1), "one line says why a file is refused"
    assert code in (0, 1, 3)
    assert out.out.startswith("the same robot") == (code == 0)
    assert out.out.startswith("NOT the same robot") == (code == 3)
    return ReplayOutput(code, out.out, out.err)


def files_of(result: Result) -> tuple[bytes, bytes, Any]:
    """The URDF, the .mbs and its certificate."""
    conversion = result.conversion
    certificate = conversion.files[conversion.settings.output.with_suffix(".proof.json")]
    return conversion.expanded or conversion.input.data, result.data, json.loads(certificate)


def made(text: str, folder: Path, **settings: Any) -> tuple[bytes, bytes, Any]:
    source = folder / "tiny.urdf"
    source.write_text(text)
    return files_of(convert(source, **{"passes": ALWAYS, **settings}))
