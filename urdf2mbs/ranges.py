"""The numbers that an option may be.  Each has its range in its type: the JSON schema shows it, an
error names it, and what is infinite or not a number is in none.

No range is narrower than what a robot or a crane may want: beyond it stands a slip of the unit, or
a number with which later ones overflow.
"""

from collections.abc import Mapping
from typing import Annotated, Any

from msgspec import Meta

#: How far two descriptions may be apart and still be the same, relative to what is compared.
#: Beyond the upper end, robots that anyone can tell apart would be the same.
LARGEST_TOLERANCE = 1e-3
Tolerance = Annotated[float, Meta(gt=0.0, le=LARGEST_TOLERANCE)]

#: m.
PositiveLength = Annotated[float, Meta(gt=0.0, le=1e6)]
#: m/s^2, along an axis of the base.
Acceleration = Annotated[float, Meta(ge=-1e3, le=1e3)]


def rounded(value: float, digits: int = 2) -> float:
    """A number that urdf2mbs chooses, to so many digits: the robot does not state the number."""
    return float(f"{value:.{digits}g}")


def describe_range(number: Mapping[str, Any]) -> str:
    """The range of a number in a JSON schema, such as "a number above 0, at most 0.001"."""
    kind = "a number" if number["type"] == "number" else "a whole number"
    if "minimum" in number and "maximum" in number:
        return f"{kind} from {number['minimum']:g} to {number['maximum']:g}"
    words = {
        "exclusiveMinimum": "above", "minimum": "from",
        "exclusiveMaximum": "below", "maximum": "at most",
    }  # fmt: skip
    said = [f"{word} {number[bound]:g}" for bound, word in words.items() if bound in number]
    return f"{kind} {', '.join(said)}"
