"""The state that the passes of one conversion share."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.mbs import model
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic, nearest
from urdf2mbs.proof.verdict import Proof
from urdf2mbs.spatial import IDENTITY, Pose, Rot, Turn, Vec, compose, rpy_turns
from urdf2mbs.urdf import written
from urdf2mbs.urdf.changes import RobotChange
from urdf2mbs.urdf.model import Joint, Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import Expansion

S = TypeVar("S")


class Settings(msgspec.Struct, frozen=True):
    """The config of one conversion, and its paths as absolute ones."""

    source: Path
    output: Path
    config: Config
    packages: dict[str, Path] = {}
    """The folders of ROS packages, by name."""
    xacro_args: dict[str, str] = {}
    """The arguments of xacro: those of the config, and those that a robot's name implies."""
    project: Path | None = None
    """The folder of the Robotran project that the output is part of; None: an .mbs alone."""
    languages: tuple[str, ...] = ("python",)
    """The languages of the project's code: ``python``, ``c``, or both."""
    folder: Path = Path()
    """The folder of the config; the paths in the config are relative to it."""
    fresh: bool = False
    """Whether to start over, without the user's edits of the .mbs."""


class Step(msgspec.Struct):
    """One URDF joint of the chain from a parent body to a body.

    A translation ``xyz`` (m), then ``turns`` about current axes, then the motion of the joint along
    or about ``axis``; each in the frame that the ones before it lead to.
    """

    joint: Joint
    xyz: Vec
    turns: tuple[Turn, ...]
    axis: Vec
    measured: str | None = None
    """The force-torque sensor that a fixed joint is.  The joint becomes six driven joints."""
    frames: dict[str, Pose] = {}
    """Links without a body of their own that move with the frame after this joint, and
    their constant pose in it; only on steps before the last."""
    joints: list[model.Joint] = []
    """The body's joints that this URDF joint became; the last one's frame is the step's."""
    coordinates: list[model.Joint] = []
    """The joints among ``joints`` that move with the URDF joint's coordinates, in their order."""

    @classmethod
    def of(cls, joint: Joint) -> Step:
        """Return the step of a joint as the URDF states it."""
        return cls(joint, joint.origin.xyz, rpy_turns(joint.origin.rpy), joint.axis)


class Segment(msgspec.Struct):
    """The links that become one body, and the joints that lead to it.

    The first segment of a conversion is the ground; it has no steps and no parent.
    """

    link: str
    """The link whose name the body takes."""
    parent: str | None
    """The ``link`` of the segment it is attached to."""
    steps: list[Step]
    parts: dict[str, Pose]
    """Every link that is rigid with the body, and its constant pose in the body frame."""
    holder: model.Body | model.Base
    """The body, or the base of the ground: it has the points and shapes."""

    @property
    def body(self) -> model.Body:
        """The body of the .mbs; the ground has none."""
        if isinstance(self.holder, model.Base):
            raise ValueError("the ground has no body: it is the base")
        return self.holder


class Names(msgspec.Struct):
    """The map from URDF to .mbs names."""

    bodies: dict[str, str] = {}
    """Link: body."""
    joints: dict[str, list[str]] = {}
    """URDF joint: all the joints that it became."""
    coordinates: dict[str, list[str]] = {}
    """Moving URDF joint: the joints that move with its coordinates (one; three of a planar joint,
    two translations and a rotation; six of a floating one)."""


def fits(name: str, patterns: Iterable[str]) -> bool:
    """Return whether a name matches one of the patterns of an option."""
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def choose(patterns: Iterable[str], names: Collection[str], code: str, what: str) -> list[str]:
    """Return the names that match the patterns of an option, in the order of the patterns.

    Args:
        patterns: The patterns, as of a shell.
        names: The names to choose from.
        code: The code of the error.
        what: The subject of the error, such as ``"no link"``.

    Raises:
        ConfigError: A pattern matches no name.
    """
    chosen: dict[str, None] = {}
    for pattern in patterns:
        fitting = [name for name in names if fnmatchcase(name, pattern)]
        if not fitting:
            hint = nearest(pattern, names) or "'*' in a pattern stands for any text: '*_foot'"
            raise ConfigError(code, f"{what} is called '{pattern}'", hint=hint)
        chosen |= dict.fromkeys(fitting)
    return list(chosen)


class File(bytes):
    """The bytes of a file to write; plain bytes are a file of kind ``ours``."""

    kind: Literal["ours", "starter", "obsolete", "base"]
    """``ours``: replaced by each conversion.  ``starter``: written only if it does not exist, and
    the user's from then on.  ``obsolete``: written by an earlier conversion, and of no use for this
    one; removed if nobody has changed it.  ``base`` of a merge: written after the output, and only
    with it."""
    replaces: bytes | None
    """The edited file, as a merge has read it.  The new file contains people's edits, too, and is
    not recorded as ours."""

    def __new__(
        cls,
        data: bytes = b"",
        kind: Literal["ours", "starter", "obsolete", "base"] = "ours",
        *,
        replaces: bytes | None = None,
    ) -> File:
        """Create the bytes of a file; ``kind`` and ``replaces`` as above."""
        file = super().__new__(cls, data)
        file.kind, file.replaces = kind, replaces
        return file


class Use(msgspec.Struct, frozen=True):
    """The purpose of a sensor or an external force of the .mbs."""

    what: str
    """Such as "contact", or "imu 'head'"."""
    link: str = ""
    """The URDF link that it belongs to."""
    rotation: Rot = IDENTITY
    """The axes of a sensor in the body frame, since a point has none."""
    spots: tuple[Vec, ...] = ()
    """Points where an external force may act, if not at its own (m, in the body frame)."""


class Summary(msgspec.Struct):
    """What a plugin reports of a finished conversion."""

    lines: list[str] = []
    """For the command line."""
    uses: dict[str, Use] = {}
    """By the name of the sensor or the external force."""
    tables: list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]] = []
    """For a page: the title, the heads of the columns, and the rows."""
    next_steps: list[str] = []
    """For the end of ``run``: commands and steps that use the files, one in each line."""


class Intent(msgspec.Struct):
    """What an earlier conversion changed on purpose, as recorded beside its .mbs."""

    passes: dict[str, dict[str, Any]] = {}
    """The options of the passes that changed the robot."""
    driven: list[str] = []
    """The joints that are driven, although the URDF has them follow others."""


class Input(msgspec.Struct):
    """The robot as it was given."""

    data: bytes = b""
    """The file of the robot, as it was read."""
    expansion: Expansion | None = None
    """The URDF that the file was expanded to; None if the file is a URDF."""
    settings: dict[str, Any] = {}
    """What the robot's file states of the config's keys, and the config does not overrule."""


class Base(msgspec.Struct):
    """The decision of insert-base."""

    floating: bool = False
    reason: str = ""
    """The reason for it, in a word or two."""
    inserted: str | None = None
    """The joint that was added to the robot, together with its parent link."""


class Checked(msgspec.Struct):
    """The result of ``check``; all other passes only read it."""

    changed: list[RobotChange] = []
    """The changes of the robot by passes and hooks since ``expand`` read it."""
    proof: Proof | None = None
    proven: bytes | None = None
    """The bytes that were compared."""
    rejected: Path | None = None
    """The path of the .mbs instead of the output, if it is not the same robot."""


def _ignore(text: str) -> None:
    """Show nothing of a pass that takes long."""


class Conversion(msgspec.Struct, eq=False):
    """One robot on its way from URDF to .mbs; every pass reads and writes this.

    docs/passes.md lists the sections that passes read and write.  A plugin keeps data of its own by
    ``state``.
    """

    settings: Settings
    input: Input = msgspec.field(default_factory=Input)
    robot: Robot = msgspec.field(default_factory=lambda: Robot(name=""))
    base: Base = msgspec.field(default_factory=Base)
    segments: dict[str, Segment] = {}
    aligned: bool = False
    """True if the frames of bodies are turned along their joints, not the URDF's."""
    mbs: model.Mbs = msgspec.field(default_factory=lambda: model.Mbs(name=""))
    names: Names = msgspec.field(default_factory=Names)
    frames: dict[str, model.LinkFrame] = {}
    """Where each URDF link's frame is, by link name (filled by assign-names)."""
    frozen: dict[str, str] = {}
    """The URDF joints that are locked at zero, and why; they are not in the .mbs."""
    meshes: dict[str, str] = {}
    """Mesh files as the URDF names them, and the stem that each one's .wrl gets."""
    files: dict[Path, bytes] = {}
    """The files to write once all passes are done; each may be a ``File``."""
    checked: Checked = msgspec.field(default_factory=Checked)
    diagnostics: list[Diagnostic] = []
    report: dict[str, Any] = {}
    """The parts of the report by passes, each under its name; no pass reads it."""
    states: dict[type, Any] = {}
    """The data of plugins, by class."""
    hook: Any = None
    """The hooks of all plugins; None in a test of one pass."""
    progress: Callable[[str], None] = _ignore
    """Shows what a pass that takes long is doing; by default, nothing is shown."""

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a field; raise an error for another attribute, which would be lost silently."""
        if name not in self.__struct_fields__:
            state = f"conversion.state(Class).{name} keeps data of a plugin"
            remedies = [nearest(name, self.__struct_fields__), state]
            remedy = "; ".join(filter(None, remedies))
            raise AttributeError(f"a Conversion has no field '{name}'; {remedy}")
        super().__setattr__(name, value)

    @property
    def packages(self) -> Packages:
        """The folders of ROS packages."""
        if Packages not in self.states:
            self.states[Packages] = Packages(self.settings.packages, self.settings.source)
        packages: Packages = self.states[Packages]
        return packages

    @property
    def written(self) -> Path:
        """The path of the .mbs."""
        return self.checked.rejected or self.settings.output

    def state(self, kind: type[S]) -> S:
        """Return the object of a class in which a plugin keeps its data; create it at first.

        A method ``sections()`` of the class may return what of the object belongs to the sections
        that passes read and write: for each section, the values that change with it.  The items of
        a list are compared one by one, so that an added item changes none of the others.
        """
        if kind not in self.states:
            self.states[kind] = kind()
        state: S = self.states[kind]
        return state

    @property
    def output_folder(self) -> Path:
        """The folder of the output: the project, or the folder of the .mbs."""
        return self.settings.project or self.settings.output.parent

    def add_file(self, name: str | os.PathLike[str], data: bytes | str) -> Path:
        """Add a file, which is written with the .mbs once all passes are done.

        Args:
            name: Its path, relative to ``output_folder``, such as ``masses.csv``.
            data: Its bytes, a ``File``, or its text, which is written in UTF-8.

        Returns:
            Its absolute path, the key in ``files``.

        Raises:
            TypeError: The data are neither bytes nor text.
            ValueError: The path is absolute.
        """
        if isinstance(data, str):
            data = data.encode()
        if not isinstance(data, bytes):
            kind = type(data).__name__
            raise TypeError(f"add_file: the data of '{name}' are {kind}; expected bytes or text")
        if Path(name).anchor:  # also a root of Windows without a drive
            raise ValueError(
                f"add_file: '{name}' is absolute; expected a path in {self.output_folder}"
            )
        path = self.output_folder / name
        self.files[path] = data
        return path

    def files_of(self, *kinds: str) -> dict[Path, bytes]:
        """Return the files of these kinds."""
        return {
            path: data
            for path, data in self.files.items()
            if getattr(data, "kind", "ours") in kinds
        }

    @property
    def expanded(self) -> bytes | None:
        """The URDF of the source with xacro expanded; None if it has no xacro."""
        return None if self.input.expansion is None else self.input.expansion.text

    def regroup(self, segments: dict[str, Segment]) -> None:
        """Replace the segments, the ground first; their bodies become the bodies of ``mbs``."""
        self.segments = segments
        self.mbs.bodies = [
            segment.body for segment in segments.values() if segment.parent is not None
        ]

    def steps(self) -> Iterator[Step]:
        """Yield the steps of all segments, from the ground outwards."""
        for segment in self.segments.values():
            yield from segment.steps

    def single_coordinates(self) -> list[tuple[Step, model.Joint]]:
        """Return the URDF's joints with one coordinate, each with its joint of the .mbs."""
        return [(step, step.coordinates[0]) for step in self.steps() if len(step.coordinates) == 1]

    def parts(self) -> dict[str, tuple[Segment, Pose]]:
        """Return each link that is part of a segment, with its constant pose in it."""
        return {
            link: (segment, pose)
            for segment in self.segments.values()
            for link, pose in segment.parts.items()
        }

    def add_point(
        self, name: str, link: str, at: Vec, code: str, what: str
    ) -> tuple[str | None, model.Point]:
        """Add an anchor point at a position on a link.

        Args:
            name: The name of the point.
            link: The link.
            at: The position, in m, in the frame of the link.
            code: The code of the error.
            what: The subject of the error, which is at this link.

        Returns:
            The name of the body (None: the base) and the point.

        Raises:
            ConfigError: The link is part of no segment.
        """
        for segment in self.segments.values():
            if link in segment.parts:
                point = model.Point(name, compose(segment.parts[link], Pose(at)).xyz)
                segment.holder.points.append(point)
                return None if segment.parent is None else segment.body.name, point
        if link in self.robot.links:
            why = "has no body of its own"
            hint: str | None = f"'passes: {{prune-massless: {{keep: [{link}]}}}}' makes it a body"
        else:
            why, hint = "does not exist", nearest(link, self.robot.links)
        raise ConfigError(code, f"{what} link '{link}', which {why}", hint=hint)

    @property
    def ground(self) -> Segment:
        """The first segment: the base and the links that are rigid with it."""
        return next(iter(self.segments.values()))

    def warn(
        self,
        code: str,
        message: str,
        *,
        link: str | None = None,
        joint: str | None = None,
        hint: str | None = None,
        line: int | None = None,
        level: Literal["warning", "note"] = "warning",
    ) -> None:
        """Warn that something of the robot is not in the .mbs as a user would expect.

        Args:
            code: The code of the message; the plugin's ``urdf2mbs_codes`` has it.
            message: The fault, in one sentence.
            link: The URDF link that the message is about.
            joint: The URDF joint that the message is about.
            hint: What to do; by default, what the meaning of the code says.
            line: The line in the URDF; by default that of the joint or link.
            level: How serious it is, unless the user says something else.
        """
        robot, expansion = self.robot, self.input.expansion
        kind, name = ("joint", joint) if joint else ("link", link)
        element = robot.joints.get(joint or "") or robot.links.get(link or "")
        if line is None and element is not None:
            line = element.line
        names = [] if expansion is None else expansion.files
        file, line = written.locate(kind, name or "", names, robot.file or "", line)
        self.diagnostics.append(Diagnostic(level, code, message, link, joint, file, line, hint))

    def note(
        self, code: str, message: str, *, link: str | None = None, joint: str | None = None
    ) -> None:
        """Add a note: a decision that the user may want to know."""
        self.warn(code, message, link=link, joint=joint, level="note")

    def settle(self, code: str, *, link: str | None = None, joint: str | None = None) -> int:
        """Remove warnings and notes of an earlier pass that no longer hold.

        Args:
            code: The code of the messages.
            link: The link that they are about; None: any.
            joint: The joint that they are about; None: any.

        Returns:
            The number of messages that were removed.
        """
        remaining = [
            diagnostic
            for diagnostic in self.diagnostics
            if diagnostic.code != code
            or (link or diagnostic.link, joint or diagnostic.joint)
            != (diagnostic.link, diagnostic.joint)
        ]
        count = len(self.diagnostics) - len(remaining)
        self.diagnostics[:] = remaining
        return count
