"""From an MJCF to the URDF of the same robot, by MuJoCo's own compiler."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import Expansion, absolute_path
from urdf2mbs_mjcf.files import FileFinder
from urdf2mbs_mjcf.losses import Losses, add_losses
from urdf2mbs_mjcf.model import Written
from urdf2mbs_mjcf.process import compile_mjcf
from urdf2mbs_mjcf.settings import make_settings
from urdf2mbs_mjcf.urdf import UrdfWriter

if TYPE_CHECKING:
    from urdf2mbs.plugin import Packages


def read(source: Path, data: bytes, packages: Packages, *, trust: bool) -> Expansion:
    """Return the URDF of an MJCF, with the settings of a config that a URDF cannot state.

    Args:
        source: The MJCF.
        data: Its bytes.
        packages: The folders of packages.
        trust: Whether the MJCF may read any file.

    Raises:
        ConversionError: The MJCF cannot be read.
    """
    xml_files = FileFinder(source, packages, trust=trust).find(data)
    model = compile_mjcf(Path(absolute_path(source)))
    losses = Losses()
    writer = UrdfWriter(model, source, losses)
    text = writer.write()
    settings = make_settings(writer, losses)
    add_losses(losses, model)
    messages = losses.list_messages(source)
    written = Written(model, writer.links, writer.joints, writer.shifts)
    return Expansion(text, xml_files, messages, settings, {Written: written})
