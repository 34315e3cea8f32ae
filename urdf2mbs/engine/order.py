"""The order of the passes: what a pass reads was written before, and is not changed afterwards.

The sections that passes read and write are listed in ``engine.sections``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence

from urdf2mbs.engine.config import Key, Lines
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.engine.sections import OPTIONAL
from urdf2mbs.messages.diagnostics import ConversionError

#: A pass, by its name in the config and its class.
Named = tuple[str, type[Pass]]


def check_order(
    passes: Sequence[Named],
    method: Sequence[str],
    lines: Lines | None = None,
    keys: Sequence[Key] | None = None,
) -> None:
    """Raise ConfigError where a pass stands at a wrong place.

    ``method`` are the built-in passes in the order of the method, which they keep among
    themselves: each of them may use what all earlier ones have done.  ``keys`` say where in the
    config each pass is named.
    """
    lines = lines or Lines()
    keys = keys or [()] * len(passes)
    _check_method(passes, method, lines, keys)
    before: list[Named] = []
    for (name, kind), at in zip(passes, keys, strict=True):
        known = {section for _, earlier in before for section in earlier.writes}
        built_in = name in method
        for section in kind.reads:
            if section not in known and not (section in OPTIONAL and built_in):
                raise _not_written(name, section, passes, lines, at)

        def wrong(message: str, hint: str, at: Key = at) -> ConversionError:
            return lines.error("stale", message, at, hint)

        others = [(one, k) for one, k in before if not (built_in and one in method)]
        check_stale(kind, kind.writes, others, wrong)
        before.append((name, kind))


def check_stale(
    pass_: type[Pass],
    changed: Collection[str],
    before: Iterable[Named],
    wrong: Callable[[str, str], ConversionError],
) -> None:
    """Raise ``wrong(message, hint)`` where a pass changes what an earlier pass has used.

    ``changed`` are the sections that the pass changes, ``before`` the passes that stand before it.
    A section that the pass says it writes is made anew, and does not count.
    """
    name = pass_.name
    for section in changed:
        for reader, kind in before:
            made = [other for other in kind.writes if other not in (section, *pass_.writes)]
            if section in kind.reads and made:
                raise wrong(
                    f"pass '{name}' changes the {section} after pass '{reader}' has made the "
                    f"{made[0]} from them",
                    f"put '{name}' before '{reader}'",
                )


def _check_method(
    passes: Sequence[Named], method: Sequence[str], lines: Lines, keys: Sequence[Key]
) -> None:
    place = {name: number for number, name in enumerate(method)}
    last = ""
    for (name, _), at in zip(passes, keys, strict=True):
        if name not in place:
            continue
        if last and place[name] < place[last]:
            raise lines.error(
                "wrong-order",
                f"pass '{name}' stands behind '{last}', which uses what '{name}' makes",
                at, f"put '{name}' before '{last}': built-in passes keep the order of the method",
            )  # fmt: skip
        last = name


def _not_written(
    name: str, section: str, passes: Sequence[Named], lines: Lines, at: Key
) -> ConversionError:
    writer = next((other for other, kind in passes if section in kind.writes), None)
    if writer is None or writer == name:
        return lines.error(
            "need-not-given",
            f"pass '{name}' reads the {section}, which no pass of this pipeline writes",
            at, "'urdf2mbs passes' lists what each pass writes; put such a pass before it",
        )  # fmt: skip
    return lines.error(
        "wrong-order",
        f"pass '{name}' reads the {section}, which '{writer}' writes only later",
        at, f"put it after: 'after: {{{writer}: {name}}}', or so in 'pipeline'",
    )  # fmt: skip
