"""Records which sections of a conversion a pass reads, by the attributes that it takes.

It works on our classes of the model, whose attributes belong to one section each.  What a pass
only walks through, as ``conversion.segments`` on the way to joints, counts as a use of the
section, too: a pass that walks over bodies needs bodies.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from urdf2mbs.conversion import Base, Conversion, Names, Segment, Step
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs import model as mbs

with suppress(ModuleNotFoundError):  # of a plugin that may be away
    from urdf2mbs_project.simulation import Simulation

#: A name that is read: before ``assign-names`` it is no part of a section.
NAME = "a name"
#: The section of each attribute that only one section has, by class.
SECTION_OF: dict[type, dict[str, str]] = {
    Conversion: {
        "robot": "robot",
        "segments": "bodies",
        "names": "names",
        "frames": "names",
        "meshes": "shapes",
    },
    Base: {"floating": "base", "inserted": "base"},
    Segment: dict.fromkeys(("link", "parent", "steps", "parts"), "bodies"),
    Step: {
        **dict.fromkeys(("joint", "xyz", "turns", "axis", "measured", "frames"), "bodies"),
        **dict.fromkeys(("joints", "coordinates"), "joints"),
    },
    Names: dict.fromkeys(("bodies", "joints", "coordinates"), "names"),
    mbs.Base: {"gravity": "base", "points": "anchors", "shapes": "shapes", "drawing": "layout"},
    mbs.Body: {
        **dict.fromkeys(("mass", "com", "inertia"), "inertias"),
        "name": NAME,
        "joints": "joints",
        "points": "anchors",
        "shapes": "shapes",
        "drawing": "layout",
    },
    mbs.Joint: {
        **dict.fromkeys(("type", "nature", "symbols", "actuated"), "joints"),
        "name": NAME,
        "q": "posture",
        "position": "layout",
    },
    mbs.Point: {
        **dict.fromkeys(("coordinates", "sensor", "extforce"), "anchors"),
        "name": NAME,
        "position": "layout",
    },
    mbs.Mbs: {
        **dict.fromkeys(
            ("cuts", "links", "user_constraints", "user_models", "user_variables"), "forces"
        ),
        "bodies": "bodies",
        "view": "view",
    },
}
if "Simulation" in globals():
    SECTION_OF[Simulation] = dict.fromkeys(("couplings", "driven"), "couplings")


@contextmanager
def recording(touched: set[str]) -> Iterator[None]:
    """Add each section whose attributes are read to a set."""
    for kind, sections in SECTION_OF.items():
        kind.__getattribute__ = _getter(kind, sections, touched)  # type: ignore[method-assign]
    try:
        yield
    finally:
        for kind in SECTION_OF:
            del kind.__getattribute__


def _getter(kind: type, sections: dict[str, str], touched: set[str]) -> Callable[..., Any]:
    plain = kind.__getattribute__

    def get(self: Any, name: str) -> Any:
        if name in sections:
            touched.add(sections[name])
        return plain(self, name)

    return get


def record(pipeline: Pipeline) -> dict[str, set[str]]:
    """Run a pipeline; return the sections that each pass reads, by its name."""
    found: dict[str, set[str]] = {}
    for configured in pipeline.passes:
        kind = type(configured.pass_)
        run = kind.run

        def recorded(self: Any, conversion: Any, run: Any = run) -> None:
            with recording(found.setdefault(self.name, set())):
                run(self, conversion)

        kind.run = recorded  # type: ignore[method-assign]
    try:
        pipeline.run()
    finally:
        for configured in pipeline.passes:
            kind = type(configured.pass_)
            kind.run = kind.run.__defaults__[0]  # type: ignore[method-assign]
    return found
