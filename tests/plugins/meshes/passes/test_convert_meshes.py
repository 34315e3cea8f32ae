"""The pass: which files there are, what the shapes say, what is told, what is left alone."""

import sys
from pathlib import Path

import numpy as np
import pytest

import urdf2mbs
from support.meshes import wrl
from support.meshes.robot import codes, convert, visual, write
from support.meshes.samples import (
    HIGH,
    LOW,
    SAMPLES,
    TRIANGLES,
    VOLUME,
    dae_textured_text,
    image,
    obj_lines,
    stl_ascii_text,
)
from support.meshes.samples import write as write_sample
from urdf2mbs.conversion import Conversion
from urdf2mbs.mbs.model import Shape
from urdf2mbs.testing import TINY
from urdf2mbs_meshes.passes.convert_meshes import ConvertMeshes


def shapes_of(conversion: Conversion) -> list[Shape]:
    return conversion.ground.holder.shapes


def file_of(conversion: Conversion, shape: Shape) -> Path:
    assert shape.url is not None
    return Path(shape.url.replace("PRJPATH", str(conversion.settings.project)))


def names_of(conversion: Conversion) -> list[str]:
    return [file_of(conversion, shape).name for shape in shapes_of(conversion)]


def shown(conversion: Conversion, shape: Shape) -> np.ndarray:
    """(faces, 3, 3): the triangles as a reader of the .mbs sees them, before T Rx Ry Rz."""
    return wrl.corners(wrl.read(conversion.files[file_of(conversion, shape)]), shape.scale)


def test_every_sample_arrives_in_the_project(tmp_path: Path) -> None:
    paths = [sample.write(tmp_path / sample.name) for sample in SAMPLES]
    conversion = convert(tmp_path, [visual(path) for path in paths])
    folder = tmp_path / "project" / "animationR" / "vrml"
    assert len(shapes_of(conversion)) == len(SAMPLES)
    for shape in shapes_of(conversion):
        assert file_of(conversion, shape).parent == folder
        assert len(shown(conversion, shape)) == len(TRIANGLES)
    report = conversion.report["convert-meshes"]
    assert (report["converted"], report["lost"]) == (len(SAMPLES), {})
    drawn = [data for path, data in conversion.files.items() if path.suffix == ".wrl"]
    assert report["bytes"] == sum(map(len, drawn))
    textures = len(conversion.files) - len(drawn)
    assert 0 < textures <= sum(sample.texture for sample in SAMPLES)


def test_equal_names_from_two_folders(tmp_path: Path) -> None:
    for name, factor in (("p", 1), ("q", 2)):
        points = [(factor * x, y, z) for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]]
        (tmp_path / name / "meshes").mkdir(parents=True)
        (tmp_path / name / "package.xml").write_text(f"<package><name>{name}</name></package>")
        (tmp_path / name / "meshes" / "arm.stl").write_text(stl_ascii_text(points * 2))
    first, second = (visual(f"package://{name}/meshes/arm.stl") for name in "pq")
    packages = {name: tmp_path / name for name in "pq"}
    conversion = convert(tmp_path, [first, second], [second], packages=packages)
    assert not codes(conversion)
    assert names_of(conversion) == ["arm.wrl", "arm_2.wrl", "arm_2.wrl"]
    assert [shown(conversion, s)[..., 0].max() for s in shapes_of(conversion)] == [1, 2, 2]


@pytest.mark.parametrize(
    "scale",
    [
        (1.0, 1.0, 1.0),
        (0.5, 2.0, 3.0),
        (-1.0, 1.0, 1.0),
        (0.001, -0.001, 0.001),
        (1.0, 1.0, -2.0),
        (-1.0, -1.0, 1.0),
        (-1.0, -2.0, -3.0),
    ],
)
def test_scale_counts_once_and_a_mirrored_mesh_faces_outward(
    tmp_path: Path, scale: tuple[float, float, float]
) -> None:
    conversion = convert(tmp_path, [visual(write_sample("stl_ascii", tmp_path), scale)])
    (shape,) = shapes_of(conversion)
    triangles = shown(conversion, shape)
    ends = np.sort(np.array([LOW, HIGH]) * scale, axis=0)
    np.testing.assert_allclose((triangles.min((0, 1)), triangles.max((0, 1))), ends, rtol=1e-6)
    assert wrl.volume(triangles) == pytest.approx(VOLUME * abs(np.prod(scale)), rel=1e-6)
    assert min(shape.scale) > 0  # no viewer is asked to draw a mirrored transform


def test_mirrored_colors_and_texture_stay_on_their_corners(tmp_path: Path) -> None:
    """Every corner, told by its place, has the same colour and texture point in both files."""
    for sample in SAMPLES:
        mesh = sample.write(tmp_path / sample.name)
        conversion = convert(tmp_path, [visual(mesh), visual(mesh, (-1.0, 1.0, 1.0))])
        looks = []
        for shape, sign in zip(shapes_of(conversion), (1, -1), strict=True):
            corners = set()
            for part in wrl.read(conversion.files[file_of(conversion, shape)]):
                points = part.points[part.faces] * (sign, 1, 1)
                for f, k in np.ndindex(*part.faces.shape):
                    color = () if part.colors is None else tuple(part.colors[f, k])
                    uv = () if part.uv is None else tuple(part.uv[f, k])
                    normal = frozenset(map(tuple, points[f].round(4).tolist()))
                    corners.add((tuple(points[f, k].round(4)), normal, color, uv))
            looks.append(corners)
        assert looks[0] == looks[1], sample.name


def test_a_mesh_without_colors_takes_the_urdfs(tmp_path: Path) -> None:
    plain, colored = (write_sample(name, tmp_path) for name in ("stl_ascii", "obj_materials"))
    light, blue = (0.2, 0.6, 1.0, 1.0), (0.0, 0.0, 1.0, 0.5)
    conversion = convert(
        tmp_path,
        [visual(plain, color=light), visual(plain, color=blue), visual(colored, color=light)],
    )
    assert names_of(conversion)[:2] == ["ascii.wrl", "ascii_0000ff_t50.wrl"]
    looks = [wrl.read(conversion.files[file_of(conversion, s)]) for s in shapes_of(conversion)]
    assert looks[0][0].rgb == {(51, 153, 255)}
    assert looks[1][0].rgb == {(0, 0, 255)}
    assert looks[1][0].material["transparency"] == [0.5]
    assert (51, 153, 255) not in set().union(*(part.rgb for part in looks[2]))


def test_names_that_a_mirrored_file_would_take(tmp_path: Path) -> None:
    for name in ("arm.stl", "ARM_mirror_x.stl"):
        (tmp_path / name).write_text(stl_ascii_text())
    meshes = [visual("arm.stl", (-1.0, 1.0, 1.0)), visual("ARM_mirror_x.stl"), visual("arm.stl")]
    names = names_of(convert(tmp_path, meshes))
    assert len({name.lower() for name in names}) == 3
    assert names[1:] == ["ARM_mirror_x.wrl", "arm.wrl"]


# --- what is told ------------------------------------------------------------------------------


def test_a_mesh_elsewhere_is_taken_with_a_note(tmp_path: Path) -> None:
    mesh = write_sample("stl_ascii", tmp_path / "far" / "meshes")
    conversion = convert(tmp_path, [visual(f"package://gone/meshes/{mesh.name}")])
    (diagnostic,) = conversion.diagnostics
    assert (diagnostic.code, diagnostic.level) == ("mesh-moved", "note")
    assert str(mesh) in diagnostic.message
    assert len(conversion.files) == 1


def test_a_mesh_of_another_robot_is_taken_with_a_warning(tmp_path: Path) -> None:
    mesh = write_sample("stl_ascii", tmp_path / "atlas" / "meshes")
    (tmp_path / "atlas" / "atlas.urdf").touch()
    conversion = convert(tmp_path, [visual(f"package://gone/meshes/{mesh.name}")])
    (diagnostic,) = conversion.diagnostics
    assert (diagnostic.code, diagnostic.level) == ("mesh-borrowed", "warning")
    assert str(mesh) in diagnostic.message
    named = convert(tmp_path, [visual(f"package://atlas/meshes/{mesh.name}")])
    assert not named.diagnostics, "the URDF names the robot that has it"
    (tmp_path / "robots").mkdir()
    (tmp_path / "package.xml").write_text("<package><name>arms</name></package>")
    of_a_file = visual(f"file:///elsewhere/arms/atlas/meshes/{mesh.name}")
    conversion = convert(tmp_path / "robots", [of_a_file])
    assert [diagnostic.code for diagnostic in conversion.diagnostics] == ["mesh-moved"], (
        "the URDF names the folder that has it"
    )


def test_a_shape_whose_mesh_is_lost_is_left_out(tmp_path: Path) -> None:
    """MBSysPad stops at a .wrl that is not there; one that the user has made is there."""
    (tmp_path / "bad.stl").write_text("no mesh")
    meshes = [visual(write_sample("stl_ascii", tmp_path)), visual("gone.stl"), visual("bad.stl")]
    conversion = convert(tmp_path, meshes)
    assert codes(conversion) == ["mesh-missing", "mesh-unreadable"]
    assert names_of(conversion) == ["ascii.wrl"]
    folder = file_of(conversion, shapes_of(conversion)[0]).parent
    folder.mkdir(parents=True)
    (folder / "gone.wrl").write_text("#VRML V2.0 utf8\n")
    conversion = convert(tmp_path, meshes)
    assert codes(conversion) == ["mesh-unreadable"]
    assert names_of(conversion) == ["ascii.wrl", "gone.wrl"]


def test_missing_meshes_are_one_warning_without_a_project_too(tmp_path: Path) -> None:
    """No mesh is read for it: the one that exists is no mesh."""
    (tmp_path / "there.stl").write_text("no mesh")
    names = [f"package://gone/meshes/{n}.stl" for n in range(40)]
    meshes = [visual(name) for name in (*names, *names, "there.stl")]
    conversion = convert(tmp_path, meshes, [visual(names[0])], project=False)
    (missing,) = [
        diagnostic for diagnostic in conversion.diagnostics if diagnostic.level == "warning"
    ]
    assert (missing.code, missing.link) == ("mesh-missing", "link0")
    assert missing.message == (
        f"40 meshes not found: '{names[0]}' (link link0 and 1 more), '{names[1]}' (link link0), "
        f"'{names[2]}' (link link0) and 37 more"
    )
    assert str(missing.hint).count("--package gone=DIR") == 1
    assert "mesh-not-converted" in {diagnostic.code for diagnostic in conversion.diagnostics}


@pytest.mark.parametrize("project", [False, True])
def test_a_missing_mesh_of_a_collision_is_named(project: bool, tmp_path: Path) -> None:
    source = tmp_path / "tiny.urdf"
    collision = '<collision><geometry><mesh filename="gone.stl"/></geometry></collision>'
    source.write_text(TINY.replace("</link>", f"{collision}</link>", 1))
    output = {"project": tmp_path / "p"} if project else tmp_path / "tiny.mbs"
    diagnostics = urdf2mbs.convert(source, output=output, base="fixed").diagnostics
    missing = [diagnostic for diagnostic in diagnostics if diagnostic.level == "warning"]
    assert [(diagnostic.code, diagnostic.level) for diagnostic in missing] == [
        ("mesh-missing", "warning")
    ]
    assert "1 mesh not found" in missing[0].message
    assert "'gone.stl' (link " in missing[0].message


def test_missing_texture_is_one_warning_for_all_meshes(tmp_path: Path) -> None:
    for name in ("a.dae", "b.dae"):
        (tmp_path / name).write_text(dae_textured_text("lost.png"))
    (tmp_path / "c.obj").write_text(obj_lines(["f 1 2 3"], "mtllib lost.mtl\n"))
    conversion = convert(tmp_path, [visual(name) for name in ("a.dae", "b.dae", "c.obj")])
    (diagnostic,) = conversion.diagnostics
    assert diagnostic.code == "mesh-file-missing"
    assert "'lost.png' (of a.dae and 1 more), 'lost.mtl' (of c.obj)" in diagnostic.message
    assert len(conversion.files) == 3


def test_up_axis_is_ignored_as_by_rviz_and_told_where_it_is_applied(tmp_path: Path) -> None:
    mesh = write_sample("dae_y_up_centimetres", tmp_path)
    for up_axis, told, high in (("apply", ["mesh-up-axis"], HIGH), ("ignore", [], (2, 6, -2))):
        conversion = convert(tmp_path, [visual(mesh)], options=ConvertMeshes(up_axis=up_axis))
        assert codes(conversion) == told
        triangles = shown(conversion, shapes_of(conversion)[0])
        np.testing.assert_allclose(triangles.max((0, 1)), high, rtol=1e-6)


def test_progress_names_each_mesh(tmp_path: Path) -> None:
    samples = [write_sample(name, tmp_path) for name in ("stl_ascii", "obj_quads")]
    conversion = convert(tmp_path, [visual(sample) for sample in samples])
    told: list[str] = []
    conversion.progress = told.append
    ConvertMeshes().run(conversion)
    assert ["1 of 2" in told[0], samples[1].name in told[1]] == [True, True]


# --- what is there already ---------------------------------------------------------------------


def test_a_lost_texture_is_put_back(tmp_path: Path) -> None:
    (tmp_path / "maple.png").write_bytes(image("PNG"))
    (tmp_path / "box.dae").write_text(dae_textured_text())
    (texture,) = [p for p in write(convert(tmp_path, [visual("box.dae")])) if p.suffix == ".png"]
    assert texture not in convert(tmp_path, [visual("box.dae")]).files
    texture.unlink()
    assert convert(tmp_path, [visual("box.dae")]).files[texture] == image("PNG")


@pytest.mark.parametrize("content", [b"#VRML V2.0 utf8\nShape {}\n", b"", b"changed by hand"])
def test_a_file_that_is_not_ours_is_left_alone(tmp_path: Path, content: bytes) -> None:
    mesh = write_sample("stl_ascii", tmp_path)
    mirrored = visual(mesh, (1.0, -1.0, 1.0))
    (target,) = write(convert(tmp_path, [mirrored]))
    ours = target.read_bytes()
    assert list(convert(tmp_path, [mirrored]).files) == [target]
    target.write_bytes(ours + b"# by hand\n" if content == b"changed by hand" else content)
    conversion = convert(tmp_path, [mirrored])
    assert codes(conversion) == ["mesh-not-ours"]
    assert str(target) in (conversion.diagnostics[0].hint or "")
    assert not conversion.files
    (shape,) = shapes_of(conversion)
    assert (file_of(conversion, shape), shape.scale) == (target, (1.0, 1.0, 1.0))


def test_a_robot_without_meshes_needs_no_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("trimesh", "collada", "PIL"):
        monkeypatch.setitem(sys.modules, package, None)
    assert convert(tmp_path, []).files == {}
