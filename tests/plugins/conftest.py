"""What the tests of plugins share."""

from __future__ import annotations

from pathlib import Path

import pytest
from installed import FOOT_CONTACTS, install


@pytest.fixture
def foot_contacts_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(install(FOOT_CONTACTS, tmp_path / "site-packages"))
