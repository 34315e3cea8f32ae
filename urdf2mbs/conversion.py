"""The state that the passes share: what is known so far of one robot's conversion."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator
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
    """What the user asked for: the config, and the paths in it from the root."""

    source: Path
    output: Path
    config: Config
    packages: dict[str, Path] = {}
    project: Path | None = None
    """The Robotran project folder that the output is part of, if one is asked for."""
    languages: tuple[str, ...] = ("python",)
    """What the project's code is written in: ``python``, ``c``, or both."""
    folder: Path = Path()
    """The folder of the config; the paths in the config are relative to it."""
    fresh: bool = False
    """Whether to start over, and forget what people changed in the .mbs."""


class Step(msgspec.Struct):
    """One URDF joint on the way from a parent body to a body.

    A shift ``xyz`` (m), then ``turns`` about current axes, then the joint's own motion
    along or about ``axis``, all in the frame reached so far.
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
        """The joint just as the URDF states it."""
        return cls(joint, joint.origin.xyz, rpy_turns(joint.origin.rpy), joint.axis)


class Segment(msgspec.Struct):
    """What becomes one body: the links that move as one, and the joints that lead to it.

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
    """What has its points and shapes: its body in the making, or the base."""

    @property
    def body(self) -> model.Body:
        """The body in the making; the ground has none."""
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
    """Moving URDF joint: the joints that move with its coordinates (one; three of a planar
    joint, two shifts and a turn; six of a floating one)."""


def fits(name: str, patterns: Iterable[str]) -> bool:
    """True if a name fits one of the patterns of an option."""
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def choose(patterns: Iterable[str], names: Collection[str], code: str, what: str) -> list[str]:
    """The names that the patterns of an option fit, in the order of the patterns.

    Raises ConfigError of that ``code`` where a pattern fits none: ``what`` is called so.
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
    """A file that a conversion makes; plain bytes are a file of kind ``ours``."""

    kind: Literal["ours", "starter", "obsolete", "orphans", "base"]
    """``ours``: written anew by each conversion.  ``starter``: written only where there is nothing
    yet, and the user's from then on.  ``obsolete``: an earlier conversion wrote it, and it fits no
    more; removed if nobody has changed it.  ``orphans`` and ``base`` of a merge: written with the
    output, before it and after it."""
    replaces: bytes | None
    """The edited file, as a merge has read it.  The new file holds the work of people, too, and is
    not recorded as ours."""

    def __new__(
        cls, data: bytes = b"",
        kind: Literal["ours", "starter", "obsolete", "orphans", "base"] = "ours",
        *, replaces: bytes | None = None,
    ) -> File:  # fmt: skip
        file = super().__new__(cls, data)
        file.kind, file.replaces = kind, replaces
        return file


class Use(msgspec.Struct, frozen=True):
    """What a sensor or an external force of the .mbs is for."""

    what: str
    """Such as "contact", or "imu 'head'"."""
    link: str = ""
    """The URDF link that it belongs to."""
    rotation: Rot = IDENTITY
    """The axes of a sensor in the body frame, since a point has none."""
    spots: tuple[Vec, ...] = ()
    """Where an external force may push, if not at its own point (m, in the body frame)."""


class Summary(msgspec.Struct):
    """What a plugin has to say of a conversion that is done."""

    lines: list[str] = []
    """For the command line."""
    uses: dict[str, Use] = {}
    """By the name of the sensor or the external force."""
    tables: list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]] = []
    """For a page: the title, the heads of the columns, and the rows."""
    next_steps: list[str] = []
    """For the end of ``run``: what to do with the files, a line for each."""


class Input(msgspec.Struct):
    """The robot as it was given."""

    data: bytes = b""
    """The file of the robot, as it was read."""
    expansion: Expansion | None = None
    """What xacro made of the file; None where there is no xacro in it."""


class Base(msgspec.Struct):
    """What insert-base decided."""

    floating: bool = False
    reason: str = ""
    """Why the base floats or not, in a word or two."""
    inserted: str | None = None
    """The joint, and with it the link above it, that was added to the robot."""


class Checked(msgspec.Struct):
    """What was found of the robot and the .mbs; for reading, but by ``check``."""

    changed: list[RobotChange] = []
    """What passes and hooks have changed of the robot since ``expand`` read it."""
    proof: Proof | None = None
    proven: bytes | None = None
    """The very bytes that were compared."""
    rejected: Path | None = None
    """Where the .mbs goes instead, as it is not the same robot."""


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
    """Moving URDF joints that are not in the .mbs, and why; held at zero."""
    meshes: dict[str, str] = {}
    """Mesh files as the URDF names them, and the stem that each one's .wrl gets."""
    files: dict[Path, bytes] = {}
    """What is written once all passes are done; each may be a ``File``."""
    checked: Checked = msgspec.field(default_factory=Checked)
    diagnostics: list[Diagnostic] = []
    report: dict[str, Any] = {}
    """What passes add to the report, each under its own name; no pass reads it."""
    states: dict[type, Any] = {}
    """What plugins know, by class."""
    pipeline: Any = None
    """What runs the passes; None in a test of one pass."""

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a field; refuse what is not a field, which would be lost without a word."""
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
    def hook(self) -> Any:
        """The hooks of all plugins."""
        return self.pipeline.plugins.hook

    def find(self, name: str) -> Any:
        """What a plugin has under a name (``urdf2mbs_api``); None: there is no such plugin."""
        return self.pipeline and self.pipeline.plugins.find(name)

    def progress(self, text: str) -> None:
        """Say what a pass that takes long is at."""
        if self.pipeline:
            self.pipeline.progress(text)

    @property
    def written(self) -> Path:
        """Where the .mbs goes."""
        return self.checked.rejected or self.settings.output

    def state(self, kind: type[S]) -> S:
        """The plugin's own object of this class; made when it is asked for first.

        A method ``sections()`` of the class gives what of the object belongs to sections that
        passes read and write: section by section, what changes when the section does.  Each item
        of a list counts by itself, so that one more changes none of the others.
        """
        if kind not in self.states:
            self.states[kind] = kind()
        found: S = self.states[kind]
        return found

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
        """The files of these kinds."""
        return {
            path: data
            for path, data in self.files.items()
            if getattr(data, "kind", "ours") in kinds
        }

    @property
    def expanded(self) -> bytes | None:
        """The URDF that xacro made of the source; None where there is no xacro in it."""
        return None if self.input.expansion is None else self.input.expansion.text

    def regroup(self, segments: dict[str, Segment]) -> None:
        """Make these the segments, the ground first; their bodies are the bodies of ``mbs``."""
        self.segments = segments
        self.mbs.bodies = [
            segment.body for segment in segments.values() if segment.parent is not None
        ]

    def steps(self) -> Iterator[Step]:
        """The URDF's joints on their way into the .mbs."""
        for segment in self.segments.values():
            yield from segment.steps

    def single_coordinates(self) -> list[tuple[Step, model.Joint]]:
        """The URDF's joints that move by one coordinate, each with its joint of the .mbs."""
        return [(step, step.coordinates[0]) for step in self.steps() if len(step.coordinates) == 1]

    def parts(self) -> dict[str, tuple[Segment, Pose]]:
        """Each link that is part of a segment, with its constant pose in it."""
        return {
            link: (segment, pose)
            for segment in self.segments.values()
            for link, pose in segment.parts.items()
        }

    def add_point(
        self, name: str, link: str, at: Vec, code: str, what: str
    ) -> tuple[str | None, model.Point]:
        """Make an anchor point at a place of a link (m, in its frame).

        Returns the name of the body (None: the base) and the point.  Raises ConfigError of that
        ``code`` where the link is part of no segment: ``what`` is at this link.
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
        return next(iter(self.segments.values()))

    def warn(
        self, code: str, message: str, *, link: str | None = None, joint: str | None = None,
        hint: str | None = None, line: int | None = None,
        level: Literal["warning", "note"] = "warning",
    ) -> None:  # fmt: skip
        """Say that something of the robot is not in the .mbs as one would expect.

        Args:
            code: The code of the message; the plugin's ``urdf2mbs_codes`` has it.
            message: What is wrong, in one sentence.
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
        """Say what was decided."""
        self.warn(code, message, link=link, joint=joint, level="note")

    def settle(self, code: str, *, link: str | None = None, joint: str | None = None) -> int:
        """Take back warnings and notes of an earlier pass that no longer hold.

        Those of ``code``; with ``link`` or ``joint``, only those that are about it.  Gives how
        many there were.
        """
        kept = [
            said
            for said in self.diagnostics
            if said.code != code
            or (link or said.link, joint or said.joint) != (said.link, said.joint)
        ]
        settled = len(self.diagnostics) - len(kept)
        self.diagnostics[:] = kept
        return settled
