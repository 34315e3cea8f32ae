"""For the tests of your own passes: a tiny robot, one pass run on it, and "is it the same?".

::

    from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass

    def test_my_pass():
        result = run_pass("my-pass", "my_pass.py", after="expand")
        assert "arm" in result.robot.links
        assert_same_robot(result)
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from urdf2mbs.api import Result, convert
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.passes.check import prove

#: A robot with a bit of all that robots have: a root with mass, a turned joint, an axis between
#: two coordinate axes, a massless link on the way (``wrist``) and one at the end (``tool``).
TINY = Path(__file__).with_name("tiny.urdf").read_text("utf-8")


def convert_text(robot: str = TINY, **settings: Any) -> Result:
    """Convert the text of a URDF; ``settings`` are those of ``urdf2mbs.convert``."""
    with TemporaryDirectory() as folder:
        source = Path(folder, "robot.urdf")
        source.write_text(robot, "utf-8")
        return convert(source, **settings)


def run_pass(
    name: str, plugin: str | os.PathLike[str] | None = None, *, after: str = "expand",
    options: Mapping[str, Any] | None = None, robot: str = TINY, **settings: Any,
) -> Result:  # fmt: skip
    """Convert a robot by the preset ``faithful`` with one pass put in ``after`` another.

    ``plugin`` is the file that brings the pass; None: a package that is installed.
    """
    return convert_text(
        robot,
        plugins=[] if plugin is None else [plugin],
        after={after: name},
        passes={name: options or {}},
        **settings,
    )


def assert_same_robot(result: Result, expected: Result | None = None) -> None:
    """Fail where the .mbs is not the same robot as the URDF that the passes left.

    With ``expected``, the same robot as the URDF of that conversion.  ``convert_text()`` is the
    tiny robot as it is, without your pass.
    """
    model = read_mbs(result.data, "robot.mbs")
    proof = prove(result.conversion, model, robot=(expected or result).robot)
    if not proof.same:
        found = [difference.message for difference in proof.differences]
        raise AssertionError("not the same robot:\n  " + "\n  ".join(found))
