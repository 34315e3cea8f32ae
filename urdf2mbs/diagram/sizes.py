"""Sizes and distances in a diagram, in pixels: how large MBSysPad draws, and what looks well."""

from __future__ import annotations

from collections import defaultdict
from math import ceil
from typing import NamedTuple

SHEET_MARGIN = 20.0
"""Around the whole diagram."""

# --- boxes ---

MIN_BOX_WIDTH, MIN_BOX_HEIGHT = 90.0, 60.0
NAME_HEIGHT = 16.0
"""A name is written 3 to 16 px above the middle of its box."""
NAME_CLEARANCE = 9.0
"""Between a name and a wire or an arrow that passes it."""
CORNER_DISTANCE = 15.0
"""From the corner of a box to the first port on its edge."""
LIMB_GAP = 30.0
"""Between two limbs side by side."""
_LETTER_GROUPS = {"ijl": 4.2, "frtI": 6.0, "_": 6.1, "mwMW": 13.4, "DGHNOQU": 10.3}
_LETTER_WIDTHS = defaultdict(
    lambda: 9.3, {letter: width for group, width in _LETTER_GROUPS.items() for letter in group}
)
"""Widths of letters in DejaVu Sans Bold, 12 px: MBSysPad's font for names."""

# --- chains of joints ---


class ChainSpacing(NamedTuple):
    """Distances along a chain of joints."""

    first: float
    """From the port of the parent to the first joint."""
    pitch: float
    """From joint to joint: the least that leaves room for a label."""
    max_pitch: float
    """The most, if a chain is stretched to be as long as that of its twin."""


VERTICAL_SPACING = ChainSpacing(first=45.0, pitch=40.0, max_pitch=70.0)
HORIZONTAL_SPACING = ChainSpacing(first=50.0, pitch=50.0, max_pitch=90.0)
"""Labels are wider than high."""
COLUMN_PITCH = 62.0
"""From one column of a folded chain to the other: labels must not touch each other."""
FORK_LENGTH = 40.0
"""From the last joint, with its label, to the edge of its box with several ports."""
FAN_SLOPE = 0.5
"""Of the wires from one port to several children: how far ahead they go for each pixel aside."""

# --- points inside a box ---

POINT_PITCH = 16.0
"""From one point to the next."""
MAX_POINTS_ACROSS, MAX_POINTS_ALONG = 8, 16
"""In a row across the chain, and in a column along it."""
SECOND_COLUMN_START, SECOND_COLUMN_SLOPE = 110.0, 0.16
"""Of the points of a second column: they are on one line from the last joint, with their arrows."""


def measure_name(name: str) -> float:
    """Return how wide a name is written, rounded up to an even number."""
    return 2.0 * ceil(sum(map(_LETTER_WIDTHS.__getitem__, name)) / 2)
