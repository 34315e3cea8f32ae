"""The pass: which files there are, what the shapes say, what is told, what is left alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from meshes import wrl
from meshes.robot import codes, convert, visual, write
from meshes.samples import (
    HIGH,
    LOW,
    SAMPLES,
    TRIANGLES,
    VOLUME,
    dae_textured_text,
    dae_y_up_centimetres,
    image,
    obj_lines,
    obj_materials,
    stl_ascii,
    stl_ascii_text,
    stl_binary_data,
)

from urdf2mbs.conversion import Conversion
from urdf2mbs.mbs.model import Shape
from urdf2mbs.passes.convert_meshes import ConvertMeshes


def shapes_of(conversion: Conversion) -> list[Shape]:
    return conversion.ground.holder.shapes


def file_of(conversion: Conversion, shape: Shape) -> Path:
    assert shape.url is not None
    project = conversion.settings.project
    return Path(shape.url.replace("PRJPATH", str(project)))


def shown(conversion: Conversion, shape: Shape) -> np.ndarray:
    """(faces, 3, 3): the triangles as a reader of the .mbs sees them, before T Rx Ry Rz."""
    return wrl.corners(wrl.read(conversion.files[file_of(conversion, shape)]), shape.scale)


def test_every_sample_arrives_in_the_project(tmp_path: Path) -> None:
    paths = []
    for sample in SAMPLES:
        (tmp_path / sample.name).mkdir()
        paths.append(sample.write(tmp_path / sample.name))
    conversion = convert(tmp_path, [visual(path) for path in paths])
    folder = tmp_path / "project" / "animationR" / "vrml"
    assert len(shapes_of(conversion)) == len(SAMPLES)
    for shape in shapes_of(conversion):
        assert file_of(conversion, shape).parent == folder
        assert len(shown(conversion, shape)) == len(TRIANGLES)
    report = conversion.facts["convert-meshes"]
    assert (report["converted"], report["lost"]) == (len(SAMPLES), {})
    drawn = [data for path, data in conversion.files.items() if path.suffix == ".wrl"]
    assert report["bytes"] == sum(map(len, drawn))
    textures = sum(sample.texture for sample in SAMPLES)
    written = [path.suffix for path in conversion.files]
    assert written.count(".wrl") == len(SAMPLES)
    assert 0 < len(written) - len(SAMPLES) <= textures


def test_several_visuals_a_link_and_equal_names_from_two_folders(tmp_path: Path) -> None:
    for name, factor in (("p", 1), ("q", 2)):
        folder = tmp_path / name / "meshes"
        folder.mkdir(parents=True)
        (tmp_path / name / "package.xml").write_text(f"<package><name>{name}</name></package>")
        points = [
            (factor * x, y, z) for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)] * 2
        ]
        (folder / "arm.stl").write_text(stl_ascii_text(points))
    conversion = convert(
        tmp_path,
        [visual("package://p/meshes/arm.stl"), visual("package://q/meshes/arm.stl")],
        [visual("package://q/meshes/arm.stl")],
        packages={"p": tmp_path / "p", "q": tmp_path / "q"},
    )
    assert not codes(conversion)
    assert [file_of(conversion, s).name for s in shapes_of(conversion)] == [
        "arm.wrl", "arm_2.wrl", "arm_2.wrl"
    ]  # fmt: skip
    assert [shown(conversion, s)[..., 0].max() for s in shapes_of(conversion)] == [1, 2, 2]


@pytest.mark.parametrize(
    "scale",
    [(1.0, 1.0, 1.0), (0.5, 2.0, 3.0), (-1.0, 1.0, 1.0), (0.001, -0.001, 0.001),
     (1.0, 1.0, -2.0), (-1.0, -1.0, 1.0), (-1.0, -2.0, -3.0)],
)  # fmt: skip
def test_scale_counts_once_and_a_mirrored_mesh_faces_outward(
    tmp_path: Path, scale: tuple[float, float, float]
) -> None:
    conversion = convert(tmp_path, [visual(stl_ascii(tmp_path), scale)])
    (shape,) = shapes_of(conversion)
    triangles = shown(conversion, shape)
    ends = np.sort(np.array([LOW, HIGH]) * scale, axis=0)
    np.testing.assert_allclose((triangles.min((0, 1)), triangles.max((0, 1))), ends, rtol=1e-6)
    assert wrl.volume(triangles) == pytest.approx(VOLUME * abs(np.prod(scale)), rel=1e-6)
    assert min(shape.scale) > 0  # no viewer is asked to draw a mirrored transform


def test_one_mesh_in_two_scales_one_of_them_mirrored(tmp_path: Path) -> None:
    mesh = stl_ascii(tmp_path)
    scales = [(1.0, 1.0, 1.0), (2.0, 2.0, 2.0), (1.0, -1.0, 1.0), (3.0, -3.0, 3.0)]
    conversion = convert(tmp_path, [visual(mesh, scale) for scale in scales])
    names = [file_of(conversion, shape).name for shape in shapes_of(conversion)]
    assert names == ["ascii.wrl", "ascii.wrl", "ascii_mirror_y.wrl", "ascii_mirror_y.wrl"]
    for shape, scale in zip(shapes_of(conversion), scales, strict=True):
        triangles = shown(conversion, shape)
        assert wrl.volume(triangles) == pytest.approx(VOLUME * abs(np.prod(scale)), rel=1e-6)
        assert np.sign(triangles[..., 1].mean()) == np.sign(scale[1])


def test_mirrored_colors_and_texture_stay_on_their_corners(tmp_path: Path) -> None:
    # every corner, told by its place, has the same colour and texture point in both files
    for sample in SAMPLES:
        (tmp_path / sample.name).mkdir()
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
    plain, own = stl_ascii(tmp_path), obj_materials(tmp_path)
    light, blue = (0.2, 0.6, 1.0, 1.0), (0.0, 0.0, 1.0, 0.5)
    conversion = convert(
        tmp_path, [visual(plain, color=light), visual(plain, color=blue), visual(own, color=light)]
    )
    first, second, third = shapes_of(conversion)
    assert file_of(conversion, first).name == "ascii.wrl"
    assert file_of(conversion, second).name == "ascii_0000ff_t50.wrl"
    looks = [wrl.read(conversion.files[file_of(conversion, s)]) for s in (first, second, third)]
    assert looks[0][0].rgb == {(51, 153, 255)}
    assert looks[1][0].rgb == {(0, 0, 255)}
    assert looks[1][0].material["transparency"] == [0.5]
    assert (51, 153, 255) not in set().union(*(part.rgb for part in looks[2]))


def test_names_that_a_mirrored_file_would_take(tmp_path: Path) -> None:
    (tmp_path / "arm.stl").write_text(stl_ascii_text())
    (tmp_path / "ARM_mirror_x.stl").write_text(stl_ascii_text())
    meshes = [visual("arm.stl", (-1.0, 1.0, 1.0)), visual("ARM_mirror_x.stl"), visual("arm.stl")]
    conversion = convert(tmp_path, meshes)
    names = [file_of(conversion, shape).name for shape in shapes_of(conversion)]
    assert len({name.lower() for name in names}) == 3
    assert names[1:] == ["ARM_mirror_x.wrl", "arm.wrl"]


def test_a_mesh_elsewhere_is_taken_with_a_note(tmp_path: Path) -> None:
    (tmp_path / "far" / "meshes").mkdir(parents=True)
    stl_ascii(tmp_path / "far" / "meshes")
    (name,) = [path.name for path in (tmp_path / "far" / "meshes").iterdir()]
    conversion = convert(tmp_path, [visual(f"package://gone/meshes/{name}")])
    (one,) = conversion.diagnostics
    assert (one.code, one.level) == ("mesh-moved", "note")
    assert str(tmp_path / "far" / "meshes" / name) in one.message
    assert len(conversion.files) == 1


def test_missing_mesh_is_named_with_where_it_was_looked_for(tmp_path: Path) -> None:
    mesh = stl_ascii(tmp_path)
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "package.xml").write_text("<package><name>p</name></package>")
    conversion = convert(
        tmp_path,
        [visual("package://p/gone.stl"), visual(mesh)],
        [visual("package://p/gone.stl", (1.0, -1.0, 1.0))],
        [visual("package://nowhere_at_all/a.stl")],
        packages={"p": tmp_path / "p"},
    )
    (one,) = conversion.diagnostics
    assert (one.code, one.link) == ("mesh-missing", "link0")
    assert one.message == (
        "2 meshes not found: 'package://p/gone.stl' (link link0 and 1 more), "
        "'package://nowhere_at_all/a.stl' (link link2)"
    )
    assert str(tmp_path / "p") in (one.hint or "")
    assert "nowhere_at_all" in (one.hint or "")
    lost = conversion.facts["convert-meshes"]["lost"]
    assert lost["package://p/gone.stl"]["links"] == ["link0", "link1"]
    assert len(conversion.files) == 1
    assert [shape.scale for shape in shapes_of(conversion)][2] == (1.0, -1.0, 1.0)


def test_unreadable_mesh_leaves_the_rest_intact(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_bytes(stl_binary_data()[:99])
    conversion = convert(tmp_path, [visual("bad.stl"), visual(stl_ascii(tmp_path))])
    assert codes(conversion) == ["mesh-unreadable"]
    assert str(tmp_path / "bad.stl") in (conversion.diagnostics[0].hint or "")
    assert [path.name for path in conversion.files] == ["ascii.wrl"]


def test_missing_texture_is_one_warning_for_all_meshes(tmp_path: Path) -> None:
    for name in ("a.dae", "b.dae"):
        (tmp_path / name).write_text(dae_textured_text("lost.png"))
    (tmp_path / "c.obj").write_text(obj_lines(["f 1 2 3"], "mtllib lost.mtl\n"))
    meshes = [visual("a.dae"), visual("b.dae"), visual("c.obj")]
    conversion = convert(tmp_path, meshes)
    (one,) = conversion.diagnostics
    assert one.code == "mesh-file-missing"
    assert "2 files" in one.message
    assert "'lost.png' (of a.dae and 1 more), 'lost.mtl' (of c.obj)" in one.message
    assert len(conversion.files) == 3


def test_up_axis_is_ignored_as_by_rviz_and_told_where_it_is_applied(tmp_path: Path) -> None:
    mesh = dae_y_up_centimetres(tmp_path)
    apply = ConvertMeshes(up_axis="apply")
    conversion = convert(tmp_path, [visual(mesh)], options=apply)
    assert codes(conversion) == ["mesh-up-axis"]
    assert "1 mesh turned so that z is up" in conversion.diagnostics[0].message
    np.testing.assert_allclose(
        shown(conversion, shapes_of(conversion)[0]).max((0, 1)), HIGH, rtol=1e-6
    )
    ignoring = convert(tmp_path, [visual(mesh)])
    assert not codes(ignoring)
    triangles = shown(ignoring, shapes_of(ignoring)[0])
    np.testing.assert_allclose(triangles.max((0, 1)), (2, 6, -2), rtol=1e-6)


def test_a_lost_texture_is_put_back(tmp_path: Path) -> None:
    (tmp_path / "maple.png").write_bytes(image("PNG"))
    (tmp_path / "box.dae").write_text(dae_textured_text())
    first = convert(tmp_path, [visual("box.dae")])
    (texture,) = [path for path in write(first) if path.suffix == ".png"]
    texture.unlink()
    again = convert(tmp_path, [visual("box.dae")])
    assert again.files[texture] == image("PNG")


def test_two_files_with_the_same_fault_are_one_warning(tmp_path: Path) -> None:
    for name in ("one.obj", "two.obj"):
        (tmp_path / name).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\n")
    (said,) = convert(tmp_path, [visual("one.obj"), visual("two.obj")]).diagnostics
    assert said.code == "mesh-part"
    assert said.message.endswith(": mesh one.obj, two.obj")
    assert said.link is not None


@pytest.mark.parametrize("content", [b"#VRML V2.0 utf8\nShape {}\n", b"", b"changed by hand"])
def test_a_file_that_is_not_ours_is_left_alone(tmp_path: Path, content: bytes) -> None:
    mesh = stl_ascii(tmp_path)
    (target,) = write(convert(tmp_path, [visual(mesh, (1.0, -1.0, 1.0))]))
    ours = target.read_bytes()
    target.write_bytes(ours + b"# by hand\n" if content == b"changed by hand" else content)
    mesh.write_bytes(stl_binary_data())
    conversion = convert(tmp_path, [visual(mesh, (1.0, -1.0, 1.0))])
    assert codes(conversion) == ["mesh-not-ours"]
    assert str(target) in (conversion.diagnostics[0].hint or "")
    assert not conversion.files
    (shape,) = shapes_of(conversion)
    assert (file_of(conversion, shape), shape.scale) == (target, (1.0, 1.0, 1.0))


def test_the_same_bytes_every_time(tmp_path: Path) -> None:
    """In processes that hash strings differently."""
    paths = []
    for sample in SAMPLES:
        (tmp_path / sample.name).mkdir()
        paths.append(str(sample.write(tmp_path / sample.name)))
    program = (
        "import hashlib, sys\nfrom pathlib import Path\nfrom meshes.robot import convert, visual\n"
        "c = convert(Path(sys.argv[1]), [visual(p, (1.0, -1.0, 1.0)) for p in sys.argv[2:]])\n"
        "for p, b in c.files.items(): print(p, hashlib.sha256(b).hexdigest())\n"
    )
    outputs = set()
    for seed in ("1", "2"):
        environment = {
            **os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(Path(__file__).parents[1])
        }  # fmt: skip
        outputs.add(
            subprocess.run(
                [sys.executable, "-c", program, str(tmp_path), *paths],
                env=environment, capture_output=True, text=True, check=True,
            ).stdout
        )  # fmt: skip
    assert len(outputs) == 1
    assert outputs.pop().count("\n") > len(SAMPLES)


def test_a_robot_without_meshes_needs_no_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("trimesh", "collada", "PIL"):
        monkeypatch.setitem(sys.modules, package, None)
    conversion = convert(tmp_path, [])
    assert conversion.files == {}
    assert conversion.facts["convert-meshes"]["converted"] == 0


def test_only_a_project_gets_its_meshes_converted(tmp_path: Path) -> None:
    conversion = convert(tmp_path, [visual(stl_ascii(tmp_path))], project=False)
    assert conversion.files == {}
    assert [d.code for d in conversion.diagnostics] == ["mesh-not-converted"]


def test_progress_names_each_mesh(tmp_path: Path) -> None:
    conversion = convert(tmp_path, [visual(stl_ascii(tmp_path)), visual("gone.stl")])
    told: list[str] = []
    conversion.progress = told.append
    conversion.files.clear()
    ConvertMeshes().run(conversion)
    assert ["1 of 2" in told[0], "gone.stl" in told[1]] == [True, True]


def test_what_all_meshes_together_may_take_is_bounded(tmp_path: Path) -> None:
    """So many bytes are read of meshes that are converted, and no more."""
    data = stl_binary_data()
    paths = [tmp_path / f"{name}.stl" for name in "abc"]
    for path in paths:
        path.write_bytes(data)
    options = ConvertMeshes(at_most=2.5 * len(data) / 2**20)  # type: ignore[arg-type]
    conversion = convert(tmp_path, [visual(path) for path in paths], options=options)
    report = conversion.facts["convert-meshes"]
    assert report["converted"] == 2
    assert list(report["lost"]) == [str(paths[2])]
    assert codes(conversion) == ["mesh-too-large"]
