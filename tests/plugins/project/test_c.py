"""The generated C: compiled with all warnings as errors, and the same as Python and the laws."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from conftest import SHARED
from oracle.code import code_of, prove_code
from oracle.rich import PASSES, RICH, convert
from plugins.project.passes.test_mimic import CHAIN
from plugins.project.standin import make, without_meshes
from urdf2mbs.engine.output import write

ROOT = Path(__file__).resolve().parents[3]
HEADERS = ROOT / "plugins" / "urdf2mbs_simulate" / "mbsysc"
GRIPPER = SHARED / "robots/robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf"
#: All warnings are errors; the headers of Robotran have comments inside comments.
FLAGS = ["-std=c99", "-pedantic", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-comment"]

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not there")


def build(project: Path) -> None:
    """Compile all files.  Robotran's signatures have parameters that a user may not need."""
    generated = (f"{project.name}_robot.c", "user_model.c")
    include = [f"-I{HEADERS}", f"-I{project / 'userfctR'}"]
    folders = ['-DPROJECT_FOLDER=""', '-DBUILD_FOLDER=""']
    for file in project.rglob("*.c"):
        own = [] if file.name in generated else ["-Wno-unused-parameter"]
        command = ["gcc", *FLAGS, *own, *include, *folders, "-c", "-o", "/dev/null", str(file)]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


RUBBING = CHAIN.replace(
    '<axis xyz="0 1 0"/></joint></robot>',
    '<axis xyz="0 1 0"/><dynamics damping="0.5" friction="0.2"/></joint></robot>',
)
#: Joints and links called like words of C, like each other, and like a point's macro.
NAMES = CHAIN.replace('"one"', '"double"').replace('"two"', '"a/b"').replace('"b"', '"a b"')
NAMES = NAMES.replace('"three"', '"a_c"').replace('"d"', '"stop"').replace('"four"', '"NONE"')


@pytest.mark.parametrize(("text", "passes", "settings"), [
    (RICH, PASSES, {}),
    (RUBBING, {"mimic": {"joints": {"*": "dependent"}}}, {}),
    (RUBBING, {"mimic": {"joints": {"*": "driven"}}}, {}),
    (NAMES, {}, {"output": "while"}),
    pytest.param(
        GRIPPER, {}, {"pipeline": without_meshes("faithful"), "base": "fixed"},
        marks=pytest.mark.skipif(not GRIPPER.is_file(), reason="../shared is not there"),
    ),
], ids=["rich", "dependent", "driven", "names", "gripper"])  # fmt: skip
def test_c_does_what_python_and_the_laws_say(
    text: Any, passes: Any, settings: Any, tmp_path: Path
) -> None:
    name = settings.pop("output", "rich")
    output = {"project": str(tmp_path / name), "language": "both"}
    text = text.read_text() if isinstance(text, Path) else text
    conversion = convert(tmp_path, passes, text, output=output, **settings)
    assert prove_code(conversion, code_of(conversion, ".py", ".c", ".h"), in_c=True) == []
    write(conversion)
    build(tmp_path / name)


#: Stands for MBsysC: a run of three steps.
RUNTIME = """
#include <stdlib.h>
#include "mbs_data.h"
#include "mbs_dirdyn.h"
#include "mbs_part.h"
#include "mbs_set.h"
#include "mbs_load_xml.h"
void user_dirdyn_loop(MbsData *mbs_data, MbsDirdyn *mbs_dd);
MbsData* mbs_load(const char *file, const char *build)
{
    MbsData *data = calloc(1, sizeof(MbsData));
    data->njoint = 5;
    data->q = calloc(6, sizeof(double));
    data->qd = calloc(6, sizeof(double));
    return data;
}
void mbs_delete_data(MbsData *mbs_data) { }
void mbs_set_nb_userc(MbsData *mbs_data, int count) { }
MbsPart* mbs_new_part(MbsData *mbs_data)
{
    MbsPart *part = calloc(1, sizeof(MbsPart));
    part->options = calloc(1, sizeof(MbsPartOptions));
    return part;
}
int mbs_run_part(MbsPart *part, MbsData *mbs_data) { return mbs_data->DonePart = DONE; }
void mbs_delete_part(MbsPart *part) { }
MbsDirdyn* mbs_new_dirdyn(MbsData *mbs_data)
{
    MbsDirdyn *dirdyn = calloc(1, sizeof(MbsDirdyn));
    dirdyn->options = calloc(1, sizeof(MbsDirdynOptions));
    return dirdyn;
}
int mbs_run_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data)
{
    int k;
    for (k = 0; k < 3; k++) {
        mbs_data->tsim = 0.5 * k;
        mbs_data->qd[5] = -70.0;
        mbs_data->q[2] = k == 2 ? LAST : 0.0;
        user_dirdyn_loop(mbs_data, dirdyn);
    }
    return 0;
}
void mbs_delete_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data) { }
"""


@pytest.mark.parametrize(
    ("done", "last", "code", "says"),
    [
        (1, "0.0", 0, ""),
        (0, "0.0", 1, "there is no partition, so the loops would be open: two three cannot"),
        (1, "0.0 / zero", 1, "at 1 s the position or speed of joint one is not a number"),
    ],
)
def test_main_stops_where_robotran_cannot_go_on(
    tmp_path: Path, done: int, last: str, code: int, says: str
) -> None:
    project = make(tmp_path, CHAIN, language="c", base="fixed")
    (tmp_path / "runtime.c").write_text(f"static volatile double zero = 0.0;\n{RUNTIME}")
    sources = [*(project / "userfctR").glob("*.c"), project / "workR" / "src" / "main.c"]
    command = [
        "gcc", "-w", f"-I{HEADERS}", f"-I{project / 'userfctR'}", f"-DDONE={done}",
        f"-DLAST=({last} + zero)", '-DPROJECT_FOLDER=""', '-DBUILD_FOLDER=""',
        "-o", str(tmp_path / "exe"), str(tmp_path / "runtime.c"), *map(str, sources), "-lm",
    ]  # fmt: skip
    subprocess.run(command, check=True)
    ran = subprocess.run([tmp_path / "exe"], check=False, capture_output=True, text=True)
    assert ran.returncode == code
    assert says in ran.stderr
    assert ("done: see resultsR" in ran.stdout) == (code == 0)
    assert ran.stderr.count("error:") <= 2
    if last != "0.0":
        assert "joint four was the fastest, at 70 rad/s" in ran.stderr
