"""`--dump` tells what each pass did."""

from pathlib import Path
from typing import Any

import yaml

from support.pipelines import RAN, pipeline_of
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY
from urdf2mbs_setup.dump import Dump


def dump(folder: Path, text: str = "") -> dict[str, Any]:
    pipeline = pipeline_of(folder, text)
    pipeline.watch(Dump(folder / "dump"))
    pipeline.run()
    return {file.name: file.read_text("utf-8") for file in sorted((folder / "dump").glob("*.yaml"))}


def test_dumps_tell_what_each_pass_did(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
    texts = dump(tmp_path / "one")
    assert texts == dump(tmp_path / "two")
    assert str(tmp_path) not in "".join(texts.values())
    assert list(texts) == [f"{n:02}-{name}.yaml" for n, name in enumerate(RAN, 1)]
    assert "inertia: [0.02, 0.0, 0.0, 0.02, 0.0, 0.01]" in texts["01-expand.yaml"]
    states = {name[3:-5]: yaml.safe_load(text) for name, text in texts.items()}
    assert "segments" not in states["insert-base"]
    assert "segments" in states["prune-massless"]
    last = states[RAN[-1]]
    hand = last["segments"]["hand"]["steps"][1]["joints"]
    assert hand == ["wrist_pitch_axis_R1", "wrist_pitch", "wrist_pitch_back_R1"]
    assert last["proof"]["same"] is True


def test_dumps_end_after_the_pass_that_is_named(here: Path, capsys: Any) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\n")
    for words in (["run", "tiny.yaml", "--dump", "one"], ["convert", "tiny.urdf", "--dump", "two"]):
        assert main([*words, "--stop-after", "insert-base"]) == 0
        assert "stopped after 'insert-base': nothing is written" in capsys.readouterr().out
    run_dump, convert_dump = (
        {file.name: file.read_bytes() for file in Path(folder).glob("[!.]*")}
        for folder in ("one", "two")
    )
    assert run_dump == convert_dump
    assert min(run_dump) == "01-expand.yaml"
    assert max(run_dump).endswith("-insert-base.yaml")
    assert not (here / "tiny.mbs").exists()


def test_dumps_of_an_earlier_run_go_and_other_files_stay(tmp_path: Path) -> None:
    dump(tmp_path)
    (tmp_path / "dump" / "99-mine.yaml").write_text("mine: 1\n")
    texts = dump(tmp_path, "pipeline: [expand]\n")
    assert list(texts) == ["01-expand.yaml", "99-mine.yaml"]


def test_a_pipeline_that_writes_no_mbs_says_so(here: Path, capsys: Any) -> None:
    passes = "[expand, insert-base, prune-massless, reframe-inertia]"
    (here / "tiny.yaml").write_text(f"source: tiny.urdf\npipeline: {passes}\n")
    assert main(["run", "tiny.yaml"]) == 0
    assert capsys.readouterr().out.startswith("the pipeline writes no .mbs\n")


def test_the_expanded_text_is_dumped_where_reading_it_fails(here: Path, capsys: Any) -> None:
    """So that the line of the error can be looked up; a plain URDF is its own text."""
    xacro = TINY.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"', 1)
    (here / "odd.xacro").write_text(xacro.replace('xyz="0.1 0 0.15"', 'xyz="${1} x 0"'))
    assert main(["convert", "odd.xacro", "--dump", "states"]) == 1
    said = capsys.readouterr().err
    assert "'urdf2mbs convert --dump DIR' writes it, as DIR/expanded.urdf" in said
    line = int(said.partition("(expanded):")[2].partition(":")[0])
    expanded = here / "states" / "expanded.urdf"
    assert 'xyz="1 x 0"' in expanded.read_text().splitlines()[line - 1]
    assert main(["convert", "tiny.urdf", "--dump", "states"]) == 0
    assert not expanded.exists()
