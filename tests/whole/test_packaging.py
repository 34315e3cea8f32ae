"""A release has the addresses of its repository; an archive of git knows its version."""

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from support.folders import ROOT

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SCRIPT = ROOT / ".github" / "write_addresses.py"
HOME = "https://github.com/OWNER/urdf2mbs"
checkout = pytest.mark.skipif(not SCRIPT.exists(), reason="an sdist has no .github")


@checkout
def test_a_release_has_the_addresses_of_its_repository(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(SCRIPT))["main"](HOME, "https://OWNER.github.io/urdf2mbs/", "v1.2.3")
    urls = tomllib.loads(Path("pyproject.toml").read_text("utf-8"))["project"]["urls"]
    assert urls == {
        "Homepage": HOME,
        "Documentation": "https://OWNER.github.io/urdf2mbs/",
        "Source": HOME,
        "Issues": f"{HOME}/issues",
        "Changelog": f"{HOME}/blob/v1.2.3/CHANGELOG.md",
        "Robotran": "https://www.robotran.eu",
    }
    before, after = (
        re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", (folder / "README.md").read_text("utf-8"))
        for folder in (ROOT, tmp_path)
    )
    for (picture, target), (_, address) in zip(before, after, strict=True):
        if target.startswith(("https:", "#")):
            assert address == target
        else:
            assert address == f"{HOME}/{'raw' if picture else 'blob'}/v1.2.3/{target}"
    assert len(before) > 20


@checkout
@pytest.mark.parametrize("name", ["ci", "docs", "publish"])
def test_each_job_ends_and_each_action_is_pinned(name: str) -> None:
    text = (ROOT / ".github" / "workflows" / f"{name}.yml").read_text("utf-8")
    workflow = yaml.safe_load(text)
    assert "concurrency" in workflow
    for job in workflow["jobs"].values():
        assert job["timeout-minutes"] <= 60
        for step in job["steps"]:
            action = step.get("uses", "pypa/")  # that of PyPI is a branch, and says why
            assert action.startswith("pypa/") or re.search(r"@[0-9a-f]{40}$", action), action


@checkout
@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_an_archive_of_git_knows_its_version(tmp_path: Path) -> None:
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b.c"]
    for name in (".gitattributes", ".git_archival.txt"):
        shutil.copy(ROOT / name, tmp_path)
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "one"], ["tag", "v1.2.3"]):
        subprocess.run([*git, *words], cwd=tmp_path, check=True)
    command = ["git", "archive", "--format=zip", "-o", "archive.zip", "HEAD"]
    subprocess.run(command, cwd=tmp_path, check=True)
    shutil.unpack_archive(tmp_path / "archive.zip", tmp_path / "unpacked")
    text = (tmp_path / "unpacked" / ".git_archival.txt").read_text()
    assert re.search(r"^describe-name: v1\.2\.3$", text, re.MULTILINE)


def test_the_languages_of_the_classifiers_are_those_that_are_tested() -> None:
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    declared = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    lowest = re.search(r'requires-python = ">=(3\.\d+)"', text)
    assert lowest is not None
    assert declared[0] == lowest[1]
    if SCRIPT.exists():
        workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text("utf-8"))
        assert workflow["jobs"]["tests"]["strategy"]["matrix"]["python"] == declared
