"""Project: the code around the .mbs, so that the Robotran project starts as it is.

Beyond the method.  ``userfctR/NAME_robot.py`` (for C: ``NAME_robot.c``, ``NAME_robot.h`` and what
MBSysPad would generate) holds what is known of the robot, and is written anew at each conversion.
The user functions and the main script call it; they are written where there are none, and belong
to the user once the user has touched them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    ConversionError,
    File,
    Mbs,
    OnPurpose,
    Pass,
    counted,
    files,
    is_ours,
    some,
)
from urdf2mbs.plugin import read_mbs as read
from urdf2mbs_project.simulation import CONTACT_STATES, JOINT_STATES, Simulation, force_of

#: The endings of files in which user functions may be.
SOURCES = (".py", ".c", ".h", ".cc", ".cpp")
#: The generated module, where a user function loads it.
_MODULE = r"(?m)^(?:import |#include \")(\w+)_robot\b"


class Project(Pass):
    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        folder = conversion.settings.project
        if folder is None:
            return
        _count_as_compared(conversion)
        if conversion.checked.rejected is not None:
            return
        from urdf2mbs_project.code import EQUATIONS_FIT, starters
        from urdf2mbs_project.code.c import generated
        from urdf2mbs_project.code.python import robot_module

        mbs, simulation = conversion.mbs, conversion.state(Simulation)
        languages, user = conversion.settings.languages, folder / "userfctR"
        _check_states(conversion)
        _check_laws(conversion)
        if "python" in languages:
            conversion.add_file(f"userfctR/{mbs.name}_robot.py", robot_module(mbs, simulation))
        if "c" in languages:
            for name, data in generated(mbs, simulation).items():
                conversion.add_file(f"userfctR/{name}", data)
            _warn_of_rows_of_zeros(conversion)
        for language in languages:
            for file in EQUATIONS_FIT[language]:
                conversion.add_file(f"userfctR/{file.name}", file.read_bytes())
        of_users: set[Path] = set()
        for language in ("python", "c"):
            texts = {folder / path: data for path, data in starters(language, mbs).items()}
            of_users |= texts.keys()
            if language in languages:
                conversion.files |= {p: File(text, "starter") for p, text in texts.items()}
        _remove_obsolete(conversion, user, of_users)
        anew = [p.name for p in conversion.files_of("ours") if p.parent == user]
        once = [p.relative_to(folder).as_posix() for p in conversion.files_of("starter")]
        conversion.report["project"] = {"anew": sorted(anew), "once": sorted(once)}
        _warn_of_renamed_project(conversion)
        _warn_of_lost_names(conversion, folder)


def _count_as_compared(conversion: Conversion) -> None:
    """Take out of what the proof has not compared what this project's code computes."""
    proof, made = conversion.checked.proof, (*_made(conversion),)
    if proof is not None:
        proof.not_compared = {
            thing: why
            for thing, why in proof.not_compared.items()
            if thing in conversion.state(OnPurpose).added or not thing.startswith(made)
        }


def _made(conversion: Conversion) -> Iterator[str]:
    """What the user functions compute and no URDF has, as ``Proof.not_compared`` begins."""
    made = conversion.state(Simulation)
    for point in (*(c.point for c in made.contacts), *(w.point for w in made.wrenches)):
        yield f"force '{force_of(point)}'"
    for link in made.springs:
        yield f"link '{link.name}' ({link.kind})"
    followers = {coupling.follower.name for coupling in made.couplings}
    if not any(getattr(file, "replaces", None) for file in conversion.files.values()):
        # else people may have changed the start
        yield "start of "
    for step, joint in conversion.single_coordinates():
        if joint.name in followers:
            yield f"<mimic> of joint '{step.joint.name}'"


def _check_states(conversion: Conversion) -> None:
    """Friction of a project has states, which another pass adds to the .mbs."""
    models = {model.name for model in conversion.mbs.user_models}
    rubs = "friction_stiffness" in models or conversion.state(Simulation).contacts
    if rubs and not models & {JOINT_STATES, CONTACT_STATES}:
        raise ConfigError(
            "project-states",
            "friction of a project has states, which the pass 'friction-states' adds",
            hint="leave 'friction-states' in the pipeline",
        )


def _check_laws(conversion: Conversion) -> None:
    """A law of a plugin must be a function of its name, in each language of the project."""
    laws = conversion.state(Simulation).laws
    names = [law.name for law in laws]
    for name in names:
        if names.count(name) > 1:
            raise ConversionError(
                "law-doubled", f"two laws of plugins are called '{name}'", hint="rename one"
            )
    for law in laws:
        texts = {"python": law.python, "c": law.c}
        for language in conversion.settings.languages:
            start = "def" if language == "python" else r"static (?:double|void)"
            if not re.search(rf"(?m)^{start} {re.escape(law.name)}\(", texts[language]):
                raise ConversionError(
                    "law-missing",
                    f"the law '{law.name}' of a plugin has no function '{law.name}' in {language}",
                    hint="write its text in the plugin, or make a project in one 'language'",
                )
        conversion.note(
            "law-unknown",
            f"the law '{law.name}' is a plugin's: nothing proves it, and TIME_STEP knows nothing "
            "of it",
        )


def _warn_of_rows_of_zeros(conversion: Conversion) -> None:
    """MBsysC of 2017 keeps three rows for each ball, and puts the user's rows after these: a row
    that a planar loop does not need stays zero between others, and counts as dependent."""
    couplings = conversion.state(Simulation).couplings
    if not (conversion.mbs.cuts and couplings):
        return
    from urdf2mbs_equations.constraints import drops_row

    if drops_row(conversion.mbs):
        conversion.warn(
            "loop-row-of-zeros",
            "a loop leaves a row of zeros before the constraints of "
            f"{some(c.follower.name for c in couplings)}: the partition of "
            "MBsysC of 2017 may fail at it",
            hint="passes: {mimic: {joints: {'*': driven}}} lets the followers move without "
            "constraints; their leaders then no longer feel their mass and forces",
        )


def _remove_obsolete(conversion: Conversion, folder: Path, of_users: set[Path]) -> None:
    """Remove files of an earlier conversion that this conversion does not write."""
    there = sorted(folder.iterdir()) if files.is_folder(folder) else []
    gone = [
        path
        for path in there
        if path not in conversion.files and path not in of_users and is_ours(path)
    ]
    if gone:
        conversion.files |= dict.fromkeys(gone, File(kind="obsolete"))
        conversion.warn(
            "project-obsolete",
            f"{counted(len(gone), 'file')} of an earlier conversion fit the robot no more, and "
            f"are removed: {some(path.name for path in gone)}",
            hint="'language: both' keeps Python and C",
        )


def _warn_of_lost_names(conversion: Conversion, folder: Path) -> None:
    """User functions may name what the model had when it was written last, and has no more."""
    output = conversion.settings.output
    try:
        before = read(files.read_bytes(output), str(output), mechanics_only=True)
    except (ConversionError, OSError):
        return  # nothing is there, or nothing that can be read
    lost = _names(before) - _names(conversion.mbs)
    if not lost:
        return
    names = "|".join(sorted(map(re.escape, lost)))
    named = re.compile(rf"([\"'])({names})\1|\b({names})_id\b")
    uses = []
    for path in sorted([*folder.glob("userfctR/*"), *folder.glob("workR/**/*")]):
        own = path in conversion.files_of("ours") or is_ours(path)
        if path.suffix in SOURCES and not own:
            lines = files.read_beginning(path, 2**20).decode("utf-8", "replace").splitlines()
            for number, text in enumerate(lines, start=1):
                uses += [f"{path.name}:{number} '{a or b}'" for _, a, b in named.findall(text)]
    if uses:
        conversion.warn(
            "project-names-lost",
            f"your files use names that the model has no more: {some(uses, 6)}",
            hint="joints, forces, sensors and user models are found by their names: change these "
            "lines",
        )


def _names(mbs: Mbs) -> set[str]:
    """What user functions can find by its name."""
    points = [point for body in mbs.bodies for point in body.points]
    found = [joint.name for body in mbs.bodies for joint in body.joints]
    found += [part.name for p in points for part in (p.sensor, p.extforce) if part is not None]
    found += [connection.name for connection in (*mbs.links, *mbs.cuts)]
    found += [model.name for model in mbs.user_models]
    found += [parameter.name for model in mbs.user_models for parameter in model.parameters]
    return set(found)


def _warn_of_renamed_project(conversion: Conversion) -> None:
    """User functions that are there already may call the module of another name."""
    stale: dict[str, list[str]] = {}
    for path in conversion.files_of("starter"):
        data = files.read_beginning(path, 2**20) if files.is_file(path) else b""
        calls = re.search(_MODULE, data.decode("utf-8", "replace"))
        if calls and calls[1] != conversion.mbs.name and not is_ours(path):
            stale.setdefault(calls[1], []).append(path.name)
    for name, users in stale.items():
        new = conversion.mbs.name
        conversion.warn(
            "project-renamed",
            f"the project is called '{new}', and your files use '{name}_robot': {', '.join(users)}",
            hint=f"change '{name}_robot' to '{new}_robot' in them, or move them away",
        )
