"""The files of meshes are found by their names, in packages and in the workspace."""

import re
from pathlib import Path

import pytest

from support.packages import package, source
from urdf2mbs.urdf.packages import Packages
from urdf2mbs_meshes.files import MeshFiles


def of(folder: Path) -> MeshFiles:
    """Make the finder of a robot in a folder."""
    return MeshFiles(Packages({}, source(folder)))


def touch(file: Path) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch()
    return file


def test_the_sources_come_before_what_was_built_of_them(tmp_path: Path) -> None:
    touch(tmp_path / "install" / ".colcon_install_layout")
    touch(tmp_path / "install" / "COLCON_IGNORE")
    arm, hand = (package(tmp_path / "src" / f"{name}s" / name) for name in ("arm", "hand"))
    for folder in (hand, package(tmp_path / "install" / "hand" / "share" / "hand")):
        touch(folder / "meshes" / "m.stl")
    file = of(arm / "urdf").find("file:///home/me/hand/meshes/m.stl")
    assert file == hand / "meshes" / "m.stl"


def test_a_mesh_of_a_package_beside_the_workspace_is_data(tmp_path: Path) -> None:
    touch(tmp_path / "ws" / "arm" / ".git")
    stranger = package(tmp_path / "stranger" / "hand")
    mesh = touch(stranger / "m.stl")
    assert of(tmp_path / "ws" / "arm" / "urdf").find("package://hand/m.stl") == mesh


def test_a_folder_of_the_table_that_does_not_exist(tmp_path: Path) -> None:
    files = MeshFiles(Packages({"arm": tmp_path / "gone"}, source(tmp_path)))
    assert files.find("package://arm/m.stl") is None
    assert "gone" in files.suggest_remedy("package://arm/m.stl")


def test_a_folder_above_without_a_package_xml_has_meshes(tmp_path: Path) -> None:
    files = of(package(tmp_path / "ws" / "arm") / "urdf")
    for folder, is_found in (("ws/bare1", True), ("bare2", True), ("other/bare3", False)):
        mesh = touch(tmp_path / folder / "m.stl")
        name = f"package://{mesh.parent.name}/m.stl"
        assert files.find(name) == (mesh if is_found else None)


def test_files_of_meshes(tmp_path: Path) -> None:
    arm = package(tmp_path / "arm")
    mesh = arm / "meshes" / "a b.stl"
    mesh.parent.mkdir()
    mesh.touch()
    files = of(arm / "urdf")
    for filename in (
        *(f"{scheme}://arm/meshes/a b.stl" for scheme in ("package", "PACKAGE", "model")),
        *(
            f"{start}{mesh}"
            for start in ("file://", "file:", "file://localhost", "FILE://LocalHost")
        ),
        f"file://{mesh}".replace(" ", "%20"),
        str(mesh),
        "../meshes/a b.stl",
    ):
        file = files.find(filename)
        assert file is not None, filename
        assert file.samefile(mesh)
        assert files.suggest_remedy(filename) == f"put the file into {file.parent}"
    for drive in ("C:/a b.stl", "file:///C:/a b.stl", "file:///C:/a%20b.stl", "file:/c%3A/a.stl"):
        looked = files.suggest_remedy(drive)
        assert "into /C:" not in looked
        assert looked.endswith(":")
    for filename in (
        "package://arm/meshes",
        "package://arm/meshes/c.stl",
        "package://nobody_has_it/m.stl",
        "package://",
        "http://host/m.stl",
        "m.stl",
        "",
        "a\0b",
        "x" * 5000,
        "a/" * 99999 + "b.stl",
    ):
        assert files.find(filename) is None
        assert files.suggest_remedy(filename)
    assert "--package nobody_has_it=DIR" in files.suggest_remedy("package://nobody_has_it/m.stl")
    assert files.suggest_remedy("package://arm/c.stl") == f"put the file into {arm}"


@pytest.mark.parametrize(
    "filename",
    [
        "package://iCub/meshes/arm.stl",  # the folder is called iCub_manual
        "file:///home/somebody/ws/robot/meshes/arm.stl",
        "/home/somebody/meshes/arm.stl",
        "C:\\Users\\me\\ws\\meshes\\arm.stl",
        "file:///C:/Users/me/ws/meshes/arm.stl",
        "meshes/arm.stl",  # the folder is above the URDF
        "../../meshes/arm.stl",
    ],
)
def test_a_mesh_elsewhere_in_the_workspace_is_found(filename: str, tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    mesh = touch(tmp_path / "iCub_manual" / "meshes" / "arm.stl")
    robot = source(tmp_path / "robots" / "urdf")
    assert MeshFiles(Packages({}, robot)).find(filename) == mesh
    # which of several is meant is not known; a file of that name alone is another
    other_mesh = touch(tmp_path / "other" / "meshes" / "arm.stl")
    assert MeshFiles(Packages({}, robot)).find(filename) in (mesh, other_mesh), "they are the same"
    other_mesh.write_text("another")
    files = MeshFiles(Packages({}, robot))
    assert files.find(filename) is None
    remedy = files.suggest_remedy(filename)
    assert remedy.startswith("several files fit: ")
    assert {str(mesh), str(other_mesh)} <= set(re.split("[,; ]+", remedy))
    mesh.unlink()
    other_mesh.rename(tmp_path / "other" / "arm.stl")
    assert MeshFiles(Packages({}, robot)).find(filename) is None


def test_the_package_of_a_mesh_decides_between_two(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    mesh, _ = (touch(tmp_path / name / "meshes/m.stl") for name in ("deep/down/here/arm", "hand"))
    assert of(tmp_path / "urdf").find("package://arm/meshes/m.stl") == mesh


@pytest.mark.parametrize(
    ("worse", "better"),
    [
        ("arm/x/meshes/m.stl", "a/gone/ws/meshes/m.stl"),  # the package that the name has
        ("hand/gone2/meshes/m.stl", "arm/meshes/m.stl"),  # not that of another robot
        ("arm/x/meshes/m.stl", "arm/x/ws/meshes/m.stl"),  # the longer end
        ("meshes/m.stl", "arm/meshes/m.stl"),  # the nearer one
        ("arm/meshes/x/ws/meshes/m.stl", "arm/meshes/r/ws/meshes/m.stl"),  # called as the URDF
    ],
)
def test_the_best_of_several_meshes_is_taken(worse: str, better: str, tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    touch(tmp_path / "hand" / "urdf" / "hand.urdf")
    for name in (worse, better):
        touch(tmp_path / name).write_text(name)
    robot = touch(tmp_path / "arm" / "urdf" / "r.urdf")
    file = MeshFiles(Packages({}, robot)).find("package://gone/ws/meshes/m.stl")
    assert file == tmp_path / better


def test_no_mesh_is_taken_from_outside_the_workspace_or_from_a_huge_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = tmp_path / "ws" / "urdf"
    touch(tmp_path / "ws" / ".git")
    touch(tmp_path / "meshes" / "m.stl")
    assert of(robot).find("meshes/m.stl") is None
    touch(tmp_path / "ws" / "a" / "meshes" / "m.stl")
    assert of(robot).find("meshes/m.stl") is not None
    monkeypatch.setattr("urdf2mbs.urdf.packages.MAX_FOLDERS", 2)
    assert of(robot).find("meshes/m.stl") is None


@pytest.mark.parametrize(
    "filename",
    ["Meshes/Arm 1.STL", "meshes/arm%201.stl", "meshes\\arm 1.stl", "Meshes\\Arm%201.stl"],
)
@pytest.mark.parametrize("start", ["../", "package://arm/"])
def test_a_name_that_is_spelt_otherwise_is_found(start: str, filename: str, tmp_path: Path) -> None:
    arm = package(tmp_path / "arm")
    mesh = touch(arm / "meshes" / "arm 1.stl")
    file = of(arm / "urdf").find(start + filename)
    assert file is not None
    assert file.samefile(mesh)


def test_of_two_names_that_differ_in_case_none_is_chosen(tmp_path: Path) -> None:
    arm = package(tmp_path / "arm")
    for name in ("m.stl", "M.stl"):
        touch(arm / "meshes" / name)
    assert of(arm).find("meshes/m.STL") is None


@pytest.mark.parametrize("name", ["package:///talos/robots/t/meshes/arm/m.stl", "t/meshes/m.stl"])
def test_a_robot_out_of_its_package_finds_its_meshes_above_it(name: str, tmp_path: Path) -> None:
    """By the longest end of the name: ``t/meshes`` is the robot's, ``meshes`` of another."""
    end = name.partition("robots/")[2] or name
    mesh = touch(tmp_path / "out" / end)
    touch(tmp_path / "out" / end.removeprefix("t/"))
    assert of(tmp_path / "out" / "t" / "robots").find(name) == mesh
    assert of(tmp_path / "out" / "t" / "robots").find(name.replace("m.stl", "n.stl")) is None


def test_a_package_that_finds_nothing_says_which_path_was_tried(tmp_path: Path) -> None:
    folder = tmp_path / "wrong"
    folder.mkdir()
    files = MeshFiles(Packages({"arm": folder}, source(tmp_path / "robot")))
    assert files.find("package://arm/meshes/m.stl") is None
    tried = folder / "meshes" / "m.stl"
    assert files.suggest_remedy("package://arm/meshes/m.stl").endswith(
        f"{tried}, which does not exist"
    )
