"""User functions of several projects in one process: each imports its own modules."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from urdf2mbs_simulate.python_code import user_code


def project(folder: Path, text: str) -> Any:
    folder.mkdir()
    (folder / "helper.py").write_text(text)
    return SimpleNamespace(user_path=folder, _run=SimpleNamespace(modules={}))


def helper() -> Any:
    return __import__("helper")


def test_each_project_has_its_own_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    foreign = ModuleType("helper")
    monkeypatch.setitem(sys.modules, "helper", foreign)
    path = list(sys.path)
    first, second = project(tmp_path / "one", "at = 1"), project(tmp_path / "two", "at = 2")
    with user_code(first):
        helper().at += 10
        with user_code(second):
            assert helper().at == 2
        with user_code(first):
            assert helper().at == 11
        assert helper().at == 11
    assert helper() is foreign
    assert sys.path == path
    assert "MBsysPy" not in sys.modules
    with user_code(first):
        assert helper().at == 11
