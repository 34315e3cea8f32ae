"""Files that once broke a command, and the good ones that ``fuzz.py`` starts from."""

from pathlib import Path
from typing import Any

import pytest

from support.broken import KINDS, Finding, attempt, files_of, prepare

FILES = [(kind, file) for kind in KINDS for file in files_of(kind)]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    prepare()


@pytest.mark.parametrize(("kind", "file"), FILES, ids=[f"{k}/{file.name}" for k, file in FILES])
def test_a_result_or_an_error_of_ours(kind: str, file: Path) -> None:
    codes = attempt(kind, file.read_bytes())
    good = file.name.startswith("good") or not file.is_absolute()
    assert not any(codes) or not good, codes


def _raise(*_: Any, **__: Any) -> None:
    raise ZeroDivisionError


def test_what_must_not_be_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception, what is printed, files that are left, other equations, time."""
    good = Path("tiny.mbs").read_bytes()
    assert attempt("mbs", b"<mbsDescR7/>")[0] != ""
    with monkeypatch.context() as patch:
        patch.setattr("urdf2mbs.verification.explanation.compare", _raise)
        with pytest.raises(ZeroDivisionError):
            attempt("mbs", good)
    with monkeypatch.context() as patch:
        patch.setattr("support.broken.main", lambda words: print("\x1b[1m") or 0)
        with pytest.raises(Finding, match="prints"):
            attempt("mbs", good)
    with monkeypatch.context() as patch:
        patch.setattr("urdf2mbs_simulate.robot.Robot.bias", lambda self, q, qd: 0.0 * q)
        with pytest.raises(Finding, match="the equations are not"):
            attempt("mbs", good)
    with monkeypatch.context() as patch:
        patch.setattr("support.broken.PATIENCE", 0.0)
        with pytest.raises(Finding, match="takes"):
            attempt("mbs", good)
    with monkeypatch.context() as patch:
        patch.setattr("support.broken.main", lambda words: Path("half").write_bytes(b"") or _lie())
        with pytest.raises(Finding, match="leaves"):
            attempt("stl", b"")


def _lie() -> None:
    from urdf2mbs.messages.diagnostics import ConversionError

    raise ConversionError("robot-unreadable", "no")
