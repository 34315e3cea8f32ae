"""Ranges of numbers in options.

Each number of an option has its range in its type: the JSON schema shows it, and an error names
it.  No range contains NaN or infinity.

No range is narrower than what a robot or a crane may need.  A value beyond it has the wrong unit,
or makes later numbers overflow.
"""

from collections.abc import Mapping
from typing import Annotated, Any

from msgspec import Meta

#: Largest deviation, relative to the compared value, up to which two descriptions may be the same.
#: Beyond it, robots that anyone can tell apart would be the same.
LARGEST_TOLERANCE = 1e-3
Tolerance = Annotated[float, Meta(gt=0.0, le=LARGEST_TOLERANCE)]

#: m.
PositiveLength = Annotated[float, Meta(gt=0.0, le=1e6)]
#: m/s^2, along an axis of the base.
Acceleration = Annotated[float, Meta(ge=-1e3, le=1e3)]

_BOUNDS = {
    "exclusiveMinimum": "above",
    "minimum": "from",
    "exclusiveMaximum": "below",
    "maximum": "at most",
}


def rounded(value: float, digits: int = 2) -> float:
    """Round a number that urdf2mbs chooses, and that no robot states, to some digits."""
    return float(f"{value:.{digits}g}")


def describe_range(schema: Mapping[str, Any]) -> str:
    """Describe the range of a number, such as "a number above 0, at most 0.001".

    Args:
        schema: The JSON schema of the number.
    """
    kind = "a number" if schema["type"] == "number" else "a whole number"
    if "minimum" in schema and "maximum" in schema:
        return f"{kind} from {schema['minimum']:g} to {schema['maximum']:g}"
    limits = [f"{word} {schema[bound]:g}" for bound, word in _BOUNDS.items() if bound in schema]
    return f"{kind} {', '.join(limits)}"
