"""Project: generate the code around the .mbs, so that the Robotran project starts as it is.

Beyond the method.  ``userfctR/NAME_robot.py`` (for C: ``NAME_robot.c``, ``NAME_robot.h`` and the
files that MBSysPad would generate) describes the robot, and is written anew at each conversion.
The user functions and the main script call it; they are written if they do not exist, and belong
to the user from the first edit on.
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
    read_mbs,
    some,
)
from urdf2mbs_project.simulation import CONTACT_STATES, JOINT_STATES, Simulation, get_force_name

#: The endings of files in which user functions may be.
SOURCE_SUFFIXES = (".py", ".c", ".h", ".cc", ".cpp")
#: The line by which a user function loads the generated module.
MODULE_IMPORT = r"(?m)^(?:import |#include \")(\w+)_robot\b"
#: Number of bytes of a file of the user that are read.
MAX_READ = 2**20


class Project(Pass):
    """Generate the code of the project."""

    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        """Add the generated files and the user functions, and warn of files that no longer fit."""
        folder = conversion.settings.project
        if folder is None:
            return
        _mark_as_compared(conversion)
        if conversion.checked.rejected is not None:
            return
        _check_states(conversion)
        _check_laws(conversion)
        _add_generated_files(conversion)
        starters = _add_starter_files(conversion, folder)
        user_folder = folder / "userfctR"
        _remove_obsolete(conversion, user_folder, starters)
        generated = [path for path in conversion.files_of("ours") if path.parent == user_folder]
        once = [path.relative_to(folder).as_posix() for path in conversion.files_of("starter")]
        conversion.report["project"] = {
            "anew": sorted(path.name for path in generated),
            "once": sorted(once),
        }
        _warn_of_renamed_project(conversion)
        _warn_of_lost_names(conversion, folder)


# --- the files of the project ---


def _add_generated_files(conversion: Conversion) -> None:
    """Add the files that are written anew at each conversion."""
    from urdf2mbs_project.code import EQUATIONS_FIT
    from urdf2mbs_project.code.c import generate_c_files
    from urdf2mbs_project.code.python import generate_robot_module

    mbs, simulation = conversion.mbs, conversion.state(Simulation)
    languages = conversion.settings.languages
    if "python" in languages:
        module = generate_robot_module(mbs, simulation)
        conversion.add_file(f"userfctR/{mbs.name}_robot.py", module)
    if "c" in languages:
        for name, data in generate_c_files(mbs, simulation).items():
            conversion.add_file(f"userfctR/{name}", data)
        _warn_of_zero_rows(conversion)
    for language in languages:
        for file in EQUATIONS_FIT[language]:
            conversion.add_file(f"userfctR/{file.name}", file.read_bytes())


def _add_starter_files(conversion: Conversion, folder: Path) -> set[Path]:
    """Add the files that are written once, and belong to the user.

    Returns:
        The paths of such files in all languages.
    """
    from urdf2mbs_project.code import generate_starter_files

    paths: set[Path] = set()
    for language in ("python", "c"):
        starters = {
            folder / path: data
            for path, data in generate_starter_files(language, conversion.mbs).items()
        }
        paths |= starters.keys()
        if language in conversion.settings.languages:
            conversion.files |= {path: File(data, "starter") for path, data in starters.items()}
    return paths


def _remove_obsolete(conversion: Conversion, user_folder: Path, starters: set[Path]) -> None:
    """Remove files of an earlier conversion that this conversion does not write."""
    paths = sorted(user_folder.iterdir()) if files.is_folder(user_folder) else []
    obsolete = [
        path
        for path in paths
        if path not in conversion.files and path not in starters and is_ours(path)
    ]
    if obsolete:
        conversion.files |= dict.fromkeys(obsolete, File(kind="obsolete"))
        message = (
            f"{counted(len(obsolete), 'file')} of an earlier conversion fit the robot no more, and "
            f"are removed: {some(path.name for path in obsolete)}"
        )
        hint = "'language: both' keeps Python and C"
        conversion.warn("project-obsolete", message, hint=hint)


# --- the proof ---


def _mark_as_compared(conversion: Conversion) -> None:
    """Remove what this project's code computes from the list of what the proof has not compared."""
    proof = conversion.checked.proof
    if proof is None:
        return
    computed = tuple(_list_computed(conversion))
    added = conversion.state(OnPurpose).added
    proof.not_compared = {
        element: reason
        for element, reason in proof.not_compared.items()
        if element in added or not element.startswith(computed)
    }


def _list_computed(conversion: Conversion) -> Iterator[str]:
    """Yield the elements that user functions compute, as ``Proof.not_compared`` begins."""
    simulation = conversion.state(Simulation)
    points = [contact.point for contact in simulation.contacts]
    points += [wrench.point for wrench in simulation.wrenches]
    for point in points:
        yield f"force '{get_force_name(point)}'"
    for link in simulation.springs:
        yield f"link '{link.name}' ({link.kind})"
    if not any(getattr(file, "replaces", None) for file in conversion.files.values()):
        # A user may have changed the start position in a file that is replaced.
        yield "start of "
    followers = {coupling.follower.name for coupling in simulation.couplings}
    for step, joint in conversion.single_coordinates():
        if joint.name in followers:
            yield f"<mimic> of joint '{step.joint.name}'"


# --- checks ---


def _check_states(conversion: Conversion) -> None:
    """Raise ConfigError if friction lacks its states, which another pass adds to the .mbs."""
    models = {model.name for model in conversion.mbs.user_models}
    has_friction = "friction_stiffness" in models or conversion.state(Simulation).contacts
    if has_friction and not models & {JOINT_STATES, CONTACT_STATES}:
        message = "friction of a project has states, which the pass 'friction-states' adds"
        hint = "leave 'friction-states' in the pipeline"
        raise ConfigError("project-states", message, hint=hint)


def _check_laws(conversion: Conversion) -> None:
    """Check that each law of a plugin is a function of its name, in each language.

    Raises:
        ConversionError: A name is used twice, or a function is missing.
    """
    laws = conversion.state(Simulation).laws
    names = [law.name for law in laws]
    for name in names:
        if names.count(name) > 1:
            message = f"two laws of plugins are called '{name}'"
            raise ConversionError("law-doubled", message, hint="rename one")
    for law in laws:
        texts = {"python": law.python, "c": law.c}
        for language in conversion.settings.languages:
            start = "def" if language == "python" else r"static (?:double|void)"
            if not re.search(rf"(?m)^{start} {re.escape(law.name)}\(", texts[language]):
                message = (
                    f"the law '{law.name}' of a plugin has no function '{law.name}' in {language}"
                )
                hint = "write its text in the plugin, or make a project in one 'language'"
                raise ConversionError("law-missing", message, hint=hint)
        message = (
            f"the law '{law.name}' is a plugin's: nothing proves it, and TIME_STEP knows nothing "
            "of it"
        )
        conversion.note("law-unknown", message)


def _warn_of_zero_rows(conversion: Conversion) -> None:
    """Warn of loops and followers together, if a row of a loop is zero.

    MBsysC of 2017 keeps three rows for each ball, and puts the rows of user constraints after
    these.  A row that a planar loop does not need stays zero, before others, and the partition may
    take it for dependent.
    """
    couplings = conversion.state(Simulation).couplings
    if not (conversion.mbs.cuts and couplings):
        return
    from urdf2mbs_equations.constraints import drops_row

    if drops_row(conversion.mbs):
        followers = some(coupling.follower.name for coupling in couplings)
        message = (
            f"a loop leaves a row of zeros before the constraints of {followers}: the partition of "
            "MBsysC of 2017 may fail at it"
        )
        hint = (
            "passes: {mimic: {joints: {'*': driven}}} moves the followers without "
            "constraints; their leaders then no longer feel their mass and forces"
        )
        conversion.warn("loop-row-of-zeros", message, hint=hint)


# --- files of the user that no longer fit ---


def _warn_of_lost_names(conversion: Conversion, folder: Path) -> None:
    """Warn of user functions with names that the model has no more."""
    output = conversion.settings.output
    try:
        earlier = read_mbs(files.read_bytes(output), str(output), mechanics_only=True)
    except (ConversionError, OSError):
        return  # There is no earlier model, or none that can be read.
    lost = _list_names(earlier) - _list_names(conversion.mbs)
    if not lost:
        return
    names = "|".join(sorted(map(re.escape, lost)))
    pattern = re.compile(rf"([\"'])({names})\1|\b({names})_id\b")
    uses = []
    for path in sorted([*folder.glob("userfctR/*"), *folder.glob("workR/**/*")]):
        is_generated = path in conversion.files_of("ours") or is_ours(path)
        if path.suffix in SOURCE_SUFFIXES and not is_generated:
            lines = files.read_beginning(path, MAX_READ).decode("utf-8", "replace").splitlines()
            for number, line in enumerate(lines, start=1):
                for _, string, identifier in pattern.findall(line):
                    uses.append(f"{path.name}:{number} '{string or identifier}'")
    if uses:
        message = f"your files use names that the model has no more: {some(uses, 6)}"
        hint = (
            "joints, forces, sensors and user models are found by their names: change these lines"
        )
        conversion.warn("project-names-lost", message, hint=hint)


def _list_names(mbs: Mbs) -> set[str]:
    """List the names by which user functions can find an element of the model."""
    points = [point for body in mbs.bodies for point in body.points]
    elements = [element for point in points for element in (point.sensor, point.extforce)]
    names = {element.name for element in elements if element is not None}
    names |= {joint.name for body in mbs.bodies for joint in body.joints}
    names |= {connection.name for connection in (*mbs.links, *mbs.cuts)}
    names |= {model.name for model in mbs.user_models}
    names |= {parameter.name for model in mbs.user_models for parameter in model.parameters}
    return names


def _warn_of_renamed_project(conversion: Conversion) -> None:
    """Warn of user functions that call the generated module by an earlier name."""
    files_of_name: dict[str, list[str]] = {}
    new = conversion.mbs.name
    for path in conversion.files_of("starter"):
        data = files.read_beginning(path, MAX_READ) if files.is_file(path) else b""
        module = re.search(MODULE_IMPORT, data.decode("utf-8", "replace"))
        if module and module[1] != new and not is_ours(path):
            files_of_name.setdefault(module[1], []).append(path.name)
    for name, users in files_of_name.items():
        message = (
            f"the project is called '{new}', and your files use '{name}_robot': {', '.join(users)}"
        )
        hint = f"change '{name}_robot' to '{new}_robot' in them, or move them away"
        conversion.warn("project-renamed", message, hint=hint)
