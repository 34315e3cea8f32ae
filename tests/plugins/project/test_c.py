"""The generated C: compiled with all warnings as errors, and the same as Python and the laws."""

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from support.build import link, robot, solid
from support.folders import ROOT, SHARED
from support.project_code import code_of, prove_code
from support.project_robots import MIMIC_CHAIN as CHAIN
from support.rich_robot import PASSES, RICH, convert
from support.standin import make, without_meshes
from urdf2mbs.cli import main
from urdf2mbs.engine.output import write
from urdf2mbs.mbs.reader import read_mbs

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
        warnings = [] if file.name in generated else ["-Wno-unused-parameter"]
        command = ["gcc", *FLAGS, *warnings, *include, *folders, "-c", "-o", "/dev/null", str(file)]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


RUBBING = CHAIN.replace(
    '<axis xyz="0 1 0"/></joint></robot>',
    '<axis xyz="0 1 0"/><dynamics damping="0.5" friction="0.2"/></joint></robot>',
)
#: Joints and links called like words of C, like each other, and like a point's macro.
NAMES = CHAIN.replace('"one"', '"double"').replace('"two"', '"a/b"').replace('"b"', '"a b"')
NAMES = NAMES.replace('"three"', '"a_c"').replace('"d"', '"stop"').replace('"four"', '"NONE"')


@pytest.mark.parametrize(
    ("text", "passes", "settings"),
    [
        (RICH, PASSES, {}),
        *(
            pytest.param(RUBBING, {"mimic": {"joints": {"*": nature}}}, {}, marks=pytest.mark.slow)
            for nature in ("dependent", "driven")
        ),
        (NAMES, {}, {"output": "while"}),
        pytest.param(
            GRIPPER,
            {},
            {"pipeline": without_meshes("faithful"), "base": "fixed"},
            marks=[
                pytest.mark.skipif(not GRIPPER.is_file(), reason="../shared is not there"),
                pytest.mark.slow,
            ],
        ),
    ],
    ids=["rich", "dependent", "driven", "names", "gripper"],
)
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


def test_the_c_of_a_robot_without_user_models_compiles(tmp_path: Path) -> None:
    """A struct of C has at least one member."""
    build(make(tmp_path, robot(link("a", solid())), language="c", base="fixed"))


def take_examples(text: str) -> str:
    """Return the text with the code that its comments show."""
    text = re.sub(r"(?m)^ +\*   (.*;)$", r"*/ \1 /*", text)
    block = re.compile(r"/\* (.*;)\n((?: +\* .*;\n)+) +\* (.*;) \*/")
    return block.sub(lambda match: "\n".join(match.groups()).replace(" * ", " "), text)


def test_the_examples_compile_as_they_are(tmp_path: Path) -> None:
    """A function that no header declares is an error for compilers of today."""
    project = make(tmp_path, RICH, language="c", passes=PASSES)
    shown = {
        "user_JointForces.c": "*/ mbs_data->Qq[",
        "user_dirdyn.c": '\nset_output(force[3], "',
    }
    for name, code in shown.items():
        file = project / "userfctR" / name
        text = take_examples(file.read_text())
        assert code in text
        file.write_text(text)
    build(project)


#: Stands for MBsysC: a run of three steps.  Variables of the environment change what it does.
RUNTIME = """
#include <stdlib.h>
#include "mbs_data.h"
#include "mbs_dirdyn.h"
#include "mbs_part.h"
#include "mbs_set.h"
#include "mbs_load_xml.h"
void user_dirdyn_loop(MbsData *mbs_data, MbsDirdyn *mbs_dd);
static double number(const char *name, double value)
{
    return getenv(name) == NULL ? value : strtod(getenv(name), NULL);
}
MbsData* mbs_load(const char *file, const char *build)
{
    MbsData *data = calloc(1, sizeof(MbsData));
    data->njoint = number("N_JOINTS", 5.0);
    data->q = calloc(6, sizeof(double));
    data->qd = calloc(6, sizeof(double));
    data->user_model = number("USER_MODEL", 1.0) != 0.0 ? mbs_new_user_model() : NULL;
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
int mbs_run_part(MbsPart *part, MbsData *mbs_data)
{
    return mbs_data->DonePart = number("DONE", 1.0) != 0.0;
}
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
        mbs_data->q[2] = k == 2 ? number("LAST", 0.0) : 0.0;
        user_dirdyn_loop(mbs_data, dirdyn);
    }
    return 0;
}
void mbs_delete_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data) { }
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile a project that rubs with the stand-in of MBsysC."""
    folder = tmp_path_factory.mktemp("program")
    project = make(folder, RUBBING, language="c", base="fixed")
    (folder / "runtime.c").write_text(RUNTIME)
    sources = [*(project / "userfctR").glob("*.c"), project / "workR" / "src" / "main.c"]
    include = [f"-I{HEADERS}", f"-I{project / 'userfctR'}"]
    defines = ['-DPROJECT_FOLDER=""', '-DBUILD_FOLDER=""']
    files = ["-o", folder / "exe", folder / "runtime.c", *sources, "-lm"]
    subprocess.run(["gcc", "-w", *include, *defines, *files], check=True)
    return folder / "exe"


@pytest.mark.parametrize(
    ("environment", "code", "says"),
    [
        ({}, 0, ""),
        ({"DONE": "0"}, 1, "there is no partition, so the loops would be open: two three cannot"),
        ({"LAST": "nan"}, 1, "at 1 s the position or speed of joint one is not a number"),
        (
            {"USER_MODEL": "0"},
            1,
            "the .mbs has no user models, which this program was built with",
        ),
        (
            {"N_JOINTS": "4"},
            1,
            "the .mbs has 4 joints, and the user functions are of a model with 5",
        ),
    ],
)
def test_main_stops_where_robotran_cannot_go_on(
    program: Path, environment: dict[str, str], code: int, says: str
) -> None:
    ran = subprocess.run(
        [program], check=False, capture_output=True, text=True, env=os.environ | environment
    )
    assert ran.returncode == code
    assert says in ran.stderr
    assert ("done: see resultsR" in ran.stdout) == (code == 0)
    assert ran.stderr.count("error:") <= 2
    if "LAST" in environment:
        assert "joint four was the fastest, at 70 rad/s" in ran.stderr


#: Loads user models, whose names are read from a file: NAME, then each parameter and its type.
LOADER = """
#include <stdio.h>
#include <stdlib.h>
#include "mbs_load_xml.h"
int main(void)
{
    static char words[99][99];
    static double values[99];
    MDS_user_model_strct *models[99];
    MDS_user_models_strct list = { 0, models };
    MDS_gen_strct gen = { &list };
    char kind;
    for (int k = 0; k < 99 && scanf(" %c %98s", &kind, words[k]) == 2; k++) {
        if (kind == 'm') {
            MDS_user_model_strct *model = calloc(1, sizeof *model);
            model->name = words[k];
            model->parameter_list = calloc(99, sizeof *model->parameter_list);
            models[list.n_user_model++] = model;
        } else {
            MDS_user_model_strct *model = models[list.n_user_model - 1];
            MDS_parameter_strct *parameter = calloc(1, sizeof *parameter);
            parameter->name = words[k];
            parameter->type = kind == 's' ? 5 : 1;
            parameter->n_value = 1;
            values[k] = k;
            parameter->value_list = &values[k];
            model->parameter_list[model->n_parameter++] = parameter;
        }
    }
    UserModel *user_model = mbs_new_user_model();
    mbs_load_user_model_xml(&gen, user_model);
    printf("%g\\n", *(double *) user_model);
    return 0;
}
"""


def words_of(models: dict[str, list[str]]) -> str:
    """Return the input of LOADER."""
    lines = []
    for model, parameters in models.items():
        kind = "s" if model.endswith("_state") else "p"
        lines += [f"m {model}", *(f"{kind} {name}" for name in parameters)]
    return "\n".join(lines)


def test_user_models_are_found_by_their_names(tmp_path: Path) -> None:
    """What is gone, or is a state in another place, ends the program: nothing else is read."""
    project = make(tmp_path, RUBBING, language="c", base="fixed")
    (tmp_path / "loader.c").write_text(LOADER)
    program = tmp_path / "loader"
    command = [
        "gcc",
        "-std=c99",
        "-w",
        "-fsanitize=address,undefined",
        f"-I{HEADERS}",
        f"-I{project / 'userfctR'}",
        str(tmp_path / "loader.c"),
        str(project / "userfctR" / "user_model.c"),
        "-o",
        str(program),
    ]
    subprocess.run(command, check=True)
    mbs = read_mbs((project / "dataR" / "robot.mbs").read_bytes(), "robot.mbs")
    models = {model.name: [p.name for p in model.parameters] for model in mbs.user_models}

    def load(models: dict[str, list[str]]) -> tuple[str, str]:
        done = subprocess.run(
            [program],
            input=words_of(models),
            capture_output=True,
            text=True,
            check=False,
            env={"ASAN_OPTIONS": "detect_leaks=0"},
        )
        assert done.returncode == (1 if done.stderr else 0), done.stderr
        return done.stdout, done.stderr

    assert load(models) == ("1\n", "")
    assert load({"mine": ["a", "b"], **models}) == ("4\n", "")
    first = next(iter(models))
    for other_model, missing in (
        ({}, rf"'{models[first][0]}' of user model '{first}'"),
        ({**models, first: models[first][1:]}, rf"'{models[first][0]}' of user model '{first}'"),
        ({"my_state": ["a"], **models}, r"'\w+' of user model 'friction_state'"),
        ({**models, "friction_state": []}, r"'\w+' of user model 'friction_state'"),
    ):
        message = load(other_model)[1]
        assert re.search(missing, message), message
        assert "Convert the robot again, then build again" in message


@pytest.fixture
def mbsysc(tmp_path: Path) -> Path:
    """Return a folder that stands for the sources of MBsysC."""
    common = tmp_path / "MBsysC" / "mbs_common"
    shutil.copytree(HEADERS, common / "mbs_struct")
    void = common / "mbs_void_symbolicR"
    void.mkdir()
    functions = "accelred cons_hJ cons_jdqd dirdyna extforces gensensor invdyna link link3D sensor"
    for name in functions.split():
        (void / f"mbs_{name}_void.c").write_text("")
    (common / "mbs_module").mkdir()
    output = "void set_output(double value, const char *name) { }\n"
    (common / "mbs_module" / "runtime.c").write_text(output + RUNTIME)
    return common.parent


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not there")
def test_a_program_says_that_its_equations_do_not_fit(tmp_path: Path, mbsysc: Path) -> None:
    """CMake warns where there are none; the program compares those that it was built with."""
    project = make(tmp_path, CHAIN, language="c", base="fixed")
    build, model = project / "workR" / "build", project / "dataR" / "robot.mbs"
    libraries = [f"-D{name}:STRING=m" for name in ("LIBXML2_LIBRARY", "GSL", "GSLCBLAS")]
    folders = [f"-D{name}:STRING={mbsysc}" for name in ("LIBXML2_INCLUDE_DIR", "GSL_INCLUDE")]

    def call(*words: Any) -> tuple[int, str]:
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    code, message = call(
        "cmake",
        "-S",
        build.parent,
        "-B",
        build,
        f"-DROBOTRAN_SOURCE_DIR={mbsysc}",
        *libraries,
        *folders,
    )
    assert code == 0, message
    warning = " ".join(message.split())
    assert f'without them: urdf2mbs equations "{model}"' in warning
    compile_all = ("cmake", "--build", build, "--parallel", "2")
    code, message = call(*compile_all)
    assert code == 0, message
    code, message = call(build / "exe_robot")
    assert (code, "built without equations" in message) == (1, True), message
    assert main(["equations", str(model), "--language", "c"]) == 0
    code, message = call(*compile_all)
    assert (code, "without them" in message) == (0, False), message
    assert call(build / "exe_robot") == (0, "done: see resultsR\n")
    mass, text = "<mass>1.0</mass>", model.read_text()
    assert mass in text
    model.write_text(text.replace(mass, "<mass>3.0</mass>"))
    assert call(build / "exe_robot")[0] == 0
    model.write_text(text.replace(mass, "<mass>0.0</mass>"))
    code, message = call(build / "exe_robot")
    assert (code, "equations of another model" in message) == (1, True), message
    assert main(["equations", str(model), "--language", "c"]) == 0
    assert call(build / "exe_robot")[0] == 1
    assert call(*compile_all)[0] == 0
    assert call(build / "exe_robot")[0] == 0
