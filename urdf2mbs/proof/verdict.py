"""The verdict in words: the same on the terminal, on the page, in JSON and in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from urdf2mbs.messages.diagnostics import some

NOT_CHECKED = "NOT CHECKED"
NOT_THE_SAME = "NOT the same robot"
THE_SAME = "the same robot"


def in_words(
    differ: bool, but_for: Mapping[str, str], not_compared: Mapping[str, str],
    changes: Sequence[str] = (),
) -> str:  # fmt: skip
    """``NOT the same robot``, or ``the same robot, but for ...; not compared: ...``.

    ``but_for`` and ``not_compared`` map each thing to its reason; ``changes`` are sentences of
    what passes changed on purpose.
    """
    if differ:
        return NOT_THE_SAME
    known = [*changes, *_grouped(but_for)]
    words = THE_SAME + (f", but for {'; '.join(known)}" if known else "")
    left = "; ".join(_grouped(not_compared))
    return words + (f"; not compared: {left}" if left else "")


def _grouped(things: Mapping[str, str]) -> list[str]:
    """Things of one reason together: ``a, b (why)``."""
    by_reason: dict[str, list[str]] = {}
    for thing, why in things.items():
        by_reason.setdefault(why, []).append(thing)
    return [f"{some(names, 3)} ({why})" for why, names in by_reason.items()]
