"""For the tests of your passes: a tiny robot, a function that runs one pass, and a comparison.

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
    """Convert the text of a URDF.

    Args:
        robot: The URDF.
        settings: Those of ``urdf2mbs.convert``.
    """
    with TemporaryDirectory() as folder:
        source = Path(folder, "robot.urdf")
        source.write_text(robot, "utf-8")
        return convert(source, **settings)


def run_pass(
    name: str,
    plugin: str | os.PathLike[str] | None = None,
    *,
    after: str = "expand",
    options: Mapping[str, Any] | None = None,
    robot: str = TINY,
    **settings: Any,
) -> Result:
    """Convert a robot by the preset ``faithful``, with one more pass.

    Args:
        name: The pass.
        plugin: The file that brings the pass; None: an installed package does.
        after: The pass that it comes after.
        options: The options of the pass.
        robot: The URDF.
        settings: Those of ``urdf2mbs.convert``.
    """
    return convert_text(
        robot,
        plugins=[] if plugin is None else [plugin],
        after={after: name},
        passes={name: options or {}},
        **settings,
    )


def assert_same_robot(result: Result, expected: Result | None = None) -> None:
    """Fail if the .mbs is not the same robot as the URDF that the passes left.

    Args:
        result: The conversion.
        expected: A conversion whose URDF is the expected robot, such as ``convert_text()``, which
            is the tiny robot without your pass; None: that of ``result``.

    Raises:
        AssertionError: It is another robot; the message lists the differences.
    """
    model = read_mbs(result.data, "robot.mbs")
    proof = prove(result.conversion, model, robot=(expected or result).robot)
    if not proof.same:
        messages = [difference.message for difference in proof.differences]
        raise AssertionError("not the same robot:\n  " + "\n  ".join(messages))
