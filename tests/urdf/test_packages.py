"""Where packages are looked for, in which order, and what is said when they are not there."""

import os
from pathlib import Path

import pytest

from support.packages import package, source
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.urdf.packages import Packages, workspace


def of(folder: Path) -> Packages:
    """Return the packages of a robot in a folder."""
    return Packages({}, source(folder))


def test_the_table_comes_first(tmp_path: Path) -> None:
    package(tmp_path / "ws" / "arm")
    mine = tmp_path / "elsewhere"
    mine.mkdir()
    packages = Packages({"arm": mine}, source(tmp_path / "ws" / "arm" / "urdf"))
    assert packages.find("arm") == mine


@pytest.mark.parametrize("mark", [".git", ".colcon", ".catkin_workspace"])
@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("ws/arm", "arm"),  # the source's own package
        ("ws/checkout", "arm"),  # which may be in a folder of another name
        ("ws/hand", "hand"),  # a sibling
        ("ws/other", "hand"),  # a sibling in a folder of another name
        ("ws/stack/deep/other", "hand"),  # one in a stack beside
        ("ws/arm/inner/other", "hand"),  # one inside
        ("hand", "hand"),  # one further up
    ],
)
def test_a_workspace(tmp_path: Path, folder: str, name: str, mark: str) -> None:
    (tmp_path / mark).mkdir()
    expected = package(tmp_path / folder, name)
    below = tmp_path / "ws" / ("checkout" if folder == "ws/checkout" else "arm")
    assert of(below / "urdf" / "arms").find(name) == expected


@pytest.mark.parametrize("folder", ["src/hand", "src/other", "src/stack/other"])
def test_src_of_a_workspace_that_was_never_built(tmp_path: Path, folder: str) -> None:
    package(tmp_path / "src" / "arm")
    expected = package(tmp_path / folder, "hand")
    package(tmp_path / "hand")
    packages = of(tmp_path / "src" / "arm" / "urdf")
    assert workspace(packages.source) == tmp_path / "src"
    assert packages.find("hand") == expected


@pytest.mark.parametrize(
    "mark", ["install/.colcon_install_layout", "build/.built_by", "devel/.catkin"]
)
def test_a_workspace_that_was_built(tmp_path: Path, mark: str) -> None:
    """Packages in groups below src, which no checkout or file marks."""
    for folder in ("build", "install", "devel"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "COLCON_IGNORE").touch()
    (tmp_path / mark).touch()
    arm = package(tmp_path / "src" / "arms" / "arm")
    hand = package(tmp_path / "src" / "hands" / "hand")
    only = package(tmp_path / "install" / "tool" / "share" / "tool")
    merged = package(tmp_path / "install" / "share" / "cap")
    for folder in (hand, package(tmp_path / "install" / "hand" / "share" / "hand")):
        assert folder.is_dir()
    packages = of(arm / "urdf")
    assert packages.root == tmp_path
    # the sources come before what was built of them
    for name, folder in {"hand": hand, "tool": only, "cap": merged}.items():
        assert packages.find(name) == folder
    # an installed robot finds what is installed
    packages = of(only / "urdf")
    assert packages.find("cap") == merged
    assert packages.find("hand") == hand


@pytest.mark.parametrize("folder", ["hand", "stranger/hand", "ws/hand"])
@pytest.mark.parametrize("mark", [".git", "package.xml", None])
def test_a_package_beside_the_workspace_holds_no_code_for_us(
    tmp_path: Path, folder: str, mark: str | None
) -> None:
    if (folder, mark) == ("ws/hand", "package.xml"):
        folder = "ws/stack/hand"  # directly beside, it belongs to it
    robot = source(tmp_path / "ws" / "arm" / "urdf")
    if mark is not None:
        (tmp_path / "ws" / "arm" / mark).touch()
    stranger = package(tmp_path / folder)
    packages = Packages({}, robot)
    with pytest.raises(ConversionError) as caught:
        packages.find("hand")
    assert str(packages.root) in caught.value.message
    assert f"--package hand={stranger}" in (caught.value.hint or "")


@pytest.mark.parametrize("name", ["hand", "other"])
def test_packages_side_by_side(tmp_path: Path, name: str) -> None:
    """As in an archive: no checkout, no workspace."""
    arm = package(tmp_path / "arm")
    hand = package(tmp_path / name, "hand")
    assert of(arm / "urdf").find("hand") == hand
    if os.name == "posix":
        tmp_path.chmod(0o1777)  # anybody may put a package there
        with pytest.raises(ConversionError):
            of(arm / "urdf").find("hand")


def test_a_home_under_git_is_no_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    (tmp_path / ".git").mkdir()
    arm = package(tmp_path / "robots" / "arm")
    assert workspace(source(arm / "urdf")) == arm


def test_a_folder_of_that_name_is_not_enough_where_there_is_a_package(tmp_path: Path) -> None:
    (tmp_path / ".git").touch()
    (tmp_path / "ws" / "arm" / "hand").mkdir(parents=True)
    expected = package(tmp_path / "ws" / "hand")
    assert of(tmp_path / "ws" / "arm" / "urdf").find("hand") == expected
    package(tmp_path / "ws" / "arm" / "hand", "other")
    assert of(tmp_path / "ws" / "arm" / "urdf").find("hand") == expected


def test_without_any_package_xml(tmp_path: Path) -> None:
    packages = of(tmp_path / "iCub" / "robots" / "v2")
    (tmp_path / "iCub" / "iCub").mkdir()
    assert packages.find("iCub") == tmp_path / "iCub"
    assert packages.find("robots") == tmp_path / "iCub" / "robots"
    meshes = tmp_path / "iCub" / "robots" / "v2" / "meshes"
    meshes.mkdir()
    assert packages.find("meshes") == meshes


def test_the_ros_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = source(tmp_path / "home")
    itself = package(tmp_path / "ros" / "one")
    beside = package(tmp_path / "src" / "two")
    deep = package(tmp_path / "src" / "stack" / "folder" / "three_checkout", "three")
    inner = package(beside / "inner")  # packages are not nested
    hidden = tmp_path / "src" / "ignored"
    package(hidden / "four")
    (hidden / "COLCON_IGNORE").touch()
    share = tmp_path / "opt" / "share" / "five"
    share.mkdir(parents=True)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{itself}:{tmp_path / 'src'}:{tmp_path / 'none'}:")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'none'}:{tmp_path / 'opt'}")
    packages = Packages({}, robot)
    assert packages.find("one") == itself
    assert packages.find("two") == beside
    assert packages.find("three") == deep
    assert packages.find("five") == share
    for name in (inner.name, "four"):
        with pytest.raises(ConversionError):
            packages.find(name)


def test_a_package_that_is_nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/some/where")
    packages = Packages({"nowhere_description": tmp_path}, source(tmp_path / "home"))
    with pytest.raises(ConversionError) as caught:
        packages.find("nowhere")
    error = caught.value
    assert (error.code, error.exit_code) == ("package-not-found", 1)
    for word in (
        str(tmp_path / "home"),
        "ROS_PACKAGE_PATH=/some/where",
        "AMENT_PREFIX_PATH=(not set)",
        "table of packages (nowhere_description)",
        "'nowhere_description'?",
        "packages: {nowhere: DIR}",
        "--package nowhere=DIR",
    ):
        assert word in f"{error.message} {error.hint}"


def test_the_nearest_of_two_packages_counts(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    first, second = (package(tmp_path / folder / "hand") for folder in ("stack/in", "away/in"))
    assert of(tmp_path / "stack" / "arm").find("hand") == first
    assert of(tmp_path / "away" / "arm").find("hand") == second
    with pytest.raises(ConversionError, match=r"the table of packages \(empty\)"):
        of(tmp_path).find("foot")


def test_names_that_are_no_packages(tmp_path: Path) -> None:
    for name in ("", ".", "..", "a/b", "/etc", "a\0b"):
        with pytest.raises(ConversionError) as caught:
            of(tmp_path).find(name)
        assert caught.value.code == "package-not-found"


def test_a_folder_of_the_table_that_does_not_exist(tmp_path: Path) -> None:
    packages = Packages({"arm": tmp_path / "gone"}, source(tmp_path))
    with pytest.raises(ConfigError) as caught:
        packages.find("arm")
    assert caught.value.code == "package-folder"
    assert str(tmp_path / "gone") in caught.value.message
