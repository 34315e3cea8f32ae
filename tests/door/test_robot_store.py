"""The example robot_store.py: a robot by its name is the robot of the file in the store."""

from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.plugin import ConfigError, ConversionError
from urdf2mbs.testing import TINY

PLUGIN = Path(__file__).with_name("robot_store.py")


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A store with the robot ``tiny`` in a folder; we are elsewhere."""
    folder = tmp_path / "store"
    (folder / "arms").mkdir(parents=True)
    (folder / "arms" / "tiny.urdf").write_text(TINY)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setenv("LAB_ROBOTS", str(folder))
    return folder


def test_a_name_gives_the_bytes_of_the_file(store: Path) -> None:
    named = convert("lab:tiny", plugins=[PLUGIN])
    file = convert(store / "arms" / "tiny.urdf")
    assert named.data == file.data
    assert named.conversion.settings.packages == {"lab": store}
    assert named.conversion.settings.output == Path.cwd() / "tiny.mbs"


def test_what_is_not_in_the_store_is_an_error(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match=r"(?s)lab-robot.*no robot 'tny'.*mean 'tiny'"):
        convert("lab:tny", plugins=[PLUGIN])
    (store / "arms" / "tiny.urdf").unlink()
    with pytest.raises(ConfigError, match=r"(?s)lab-robot.*there are: none"):
        convert("lab:tiny", plugins=[PLUGIN])
    monkeypatch.delenv("LAB_ROBOTS")
    with pytest.raises(ConfigError, match=r"(?s)lab-store.*export LAB_ROBOTS"):
        convert("lab:tiny", plugins=[PLUGIN])


def test_a_name_of_another_kind_is_left_to_others(store: Path) -> None:
    with pytest.raises(ConversionError, match="file-not-found"):
        convert("other:tiny", plugins=[PLUGIN])
