"""The order of the passes: what a pass reads was written before, and is not changed afterwards.

The sections that passes read and write are listed in ``engine.sections``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import pairwise

from urdf2mbs.config.model import Key, Lines
from urdf2mbs.engine.sections import OPTIONAL
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConversionError


def check_order(
    passes: Sequence[type[Pass]], method: Sequence[str], lines: Lines, keys: Sequence[Key]
) -> None:
    """Raise ConfigError where a pass stands at a wrong place.

    ``method`` are the built-in passes in the order of the method, which they keep among
    themselves: each of them may use what all earlier ones have done.  ``keys`` say where in the
    config each pass is named.
    """
    ours = [(kind.name, at) for kind, at in zip(passes, keys, strict=True) if kind.name in method]
    for (last, _), (name, at) in pairwise(ours):
        if method.index(name) < method.index(last):
            raise lines.error(
                "wrong-order",
                f"pass '{name}' stands behind '{last}', which uses the result of '{name}'",
                at, f"put '{name}' before '{last}': built-in passes keep the order of the method",
            )  # fmt: skip
    known: set[str] = set()
    strangers: list[type[Pass]] = []
    for number, (kind, at) in enumerate(zip(passes, keys, strict=True)):
        built_in = kind.name in method
        for section in kind.reads:
            if section not in known and not (section in OPTIONAL and built_in):
                raise _not_written(kind.name, section, passes, lines, at)
        stale = find_stale(kind, kind.writes, strangers if built_in else passes[:number])
        if stale:
            raise lines.error("stale", stale[0], at, stale[1])
        known.update(kind.writes)
        if not built_in:
            strangers.append(kind)


def find_stale(
    pass_: type[Pass], changed: Collection[str], before: Iterable[type[Pass]]
) -> tuple[str, str] | None:
    """Find a section that this pass changes too late; gives the message and a hint.

    ``changed`` are the sections that the pass changes, ``before`` the passes that stand before it.
    A section that the pass says it writes is made anew, and does not count.
    """
    for section in changed:
        for reader in before:
            stale = [other for other in reader.writes if other not in (section, *pass_.writes)]
            if section in reader.reads and stale:
                return (
                    f"pass '{pass_.name}' changes the {section} after pass '{reader.name}' has "
                    f"made the {stale[0]} from them",
                    f"put '{pass_.name}' before '{reader.name}'",
                )
    return None


def _not_written(
    name: str, section: str, passes: Sequence[type[Pass]], lines: Lines, at: Key
) -> ConversionError:
    writer = next((kind.name for kind in passes if section in kind.writes), None)
    if writer is None or writer == name:
        return lines.error(
            "need-not-given",
            f"pass '{name}' reads the {section}, which no pass of this pipeline writes",
            at, "'urdf2mbs explain' lists what each pass writes; put such a pass before it",
        )  # fmt: skip
    return lines.error(
        "wrong-order",
        f"pass '{name}' reads the {section}, which '{writer}' writes only later",
        at, f"put it after: 'after: {{{writer}: {name}}}', or so in 'pipeline'",
    )  # fmt: skip
