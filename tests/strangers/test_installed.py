"""A plugin of an installed package: found, named, left out, and never in the way."""

import shutil
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from support.installed import install
from urdf2mbs.cli import main
from urdf2mbs.engine.entry_points import find_installed_plugins
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.testing import TINY, convert_text, run_pass


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of installed packages, with the plugin."""
    folder = install(tmp_path / "site-packages")
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "renaming", raising=False)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "c.yaml").write_text("source: tiny.urdf\nafter: {expand: rename-links}\n")
    return folder


def test_every_config_knows_its_passes_unless_asked_not_to(site: Path, capsys: Any) -> None:
    result = run_pass("rename-links", options={"links": {"arm": "left"}})
    assert "left" in result.robot.links
    config = str(site.parent / "c.yaml")
    assert main(["explain", "-v"]) == 0
    assert f"rename of renaming 0.1.0 ({site}/renaming.py)" in capsys.readouterr().out
    assert main(["explain", "--no-plugins"]) == 0
    assert "rename-links" not in capsys.readouterr().out
    assert main(["explain", config]) == 0
    assert main(["explain", "--no-plugins", config]) == 2
    assert "c.yaml:2: error[unknown-pass]" in capsys.readouterr().err


HOOK = "from support.plugin_files import hookimpl, make\n"


@pytest.mark.parametrize(
    "text",
    [
        "import nosuch\n",
        "import sys\nsys.exit()\n",
        "",
        HOOK + "@hookimpl\ndef urdf2mbs_pass(): pass\n",
        HOOK + "@hookimpl\ndef urdf2mbs_passes(): 1 / 0\n",
        HOOK + "@hookimpl\ndef urdf2mbs_passes(): return [make('a', print), make('', print)]\n",
    ],
)
def test_a_broken_one_blocks_nothing_and_is_named(text: str, site: Path, capsys: Any) -> None:
    (site / "renaming.py").write_text(text)
    config = site.parent / "c.yaml"
    said = "the installed plugin 'rename' (package renaming 0.1.0) is left out"
    assert main(["run", str(config)]) == 2
    err = capsys.readouterr().err
    assert "error[unknown-pass]" in err
    assert said in err, "what the config asks of it is an error, which says why"
    config.write_text("source: tiny.urdf\n")
    for words in (["run", str(config)], ["explain", str(config)], ["explain"]):
        assert main(words) == 0
        err = capsys.readouterr().err
        assert err.count(f"warning[plugin-broken]: {said}") == 1
        assert "--no-plugins" in err
    assert set(Plugins().passes) == set(Plugins(installed=False).passes)
    assert [found.code for found in convert_text().diagnostics].count("plugin-broken") == 1
    assert main(["explain", "--no-plugins"]) == 0
    assert capsys.readouterr().err == ""


def test_installed_plugins_are_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    Plugins()
    monkeypatch.setattr(metadata, "distributions", lambda **_: pytest.fail("looked up again"))
    monkeypatch.setattr(metadata, "version", lambda _: pytest.fail("looked up again"))
    Plugins()


def test_a_package_that_only_importlib_metadata_can_see_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a zip file on the path, and by a finder of its own on ``sys.meta_path``."""
    folder = install(tmp_path / "elsewhere")
    packed = shutil.make_archive(str(tmp_path / "packed"), "zip", folder)
    found = metadata.Distribution.at(folder / "renaming-0.1.0.dist-info")

    class Finder:
        def find_spec(self, *_: object) -> None:
            return None

        def find_distributions(self, *_: object) -> list[metadata.Distribution]:
            return [found]

    def seen() -> set[str]:
        find_installed_plugins.cache_clear()
        return {entry.name for entry, _ in find_installed_plugins(tuple(sys.path))}

    assert "rename" not in seen()
    with monkeypatch.context() as patch:
        patch.syspath_prepend(packed)
        assert "rename" in seen()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "meta_path", [*sys.meta_path, Finder()])
        assert "rename" in seen()
    find_installed_plugins.cache_clear()
