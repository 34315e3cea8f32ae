"""The contract of passes: what a pass reads was written before, and is not changed afterwards.

The sections that passes read and write are listed in ``engine.sections``.  Two rules are checked
before a run, from what the passes declare:

* a section that a pass reads was written before, and
* so was what a section is about that the pass writes: a posture is of joints.

Two are checked while a plugin's pass takes part, from what the passes really do:

* no pass changes a section from which an earlier pass made another, and
* a pass declares the sections that it changes (else a warning).

The tests hold our own passes against all four, as if they were a stranger's.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import pairwise

from urdf2mbs.config.model import Key, Lines
from urdf2mbs.engine.sections import ABOUT, OPTIONAL
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConversionError


def check_order(
    passes: Sequence[type[Pass]], method: Sequence[str], lines: Lines, keys: Sequence[Key]
) -> None:
    """Check the places of the passes of a pipeline.

    Args:
        passes: The passes in their order.
        method: The names of our own passes in the order of the method, which they keep among
            themselves: each of them may use what all earlier ones have done.
        lines: Where each value of the config stands.
        keys: Where in the config each pass is named.

    Raises:
        ConfigError: ``wrong-order`` or ``need-not-given``.
    """
    ours = [(kind.name, key) for kind, key in zip(passes, keys, strict=True) if kind.name in method]
    for (last, _), (name, key) in pairwise(ours):
        if method.index(name) < method.index(last):
            message = f"pass '{name}' is placed after '{last}', which uses the result of '{name}'"
            hint = f"put '{name}' before '{last}': our own passes keep the order of the method"
            raise lines.error("wrong-order", message, key, hint)
    written: set[str] = set()
    for kind, key in zip(passes, keys, strict=True):
        for section in kind.reads:
            if section not in written and section not in OPTIONAL:
                raise _explain_missing(kind, section, "reads", passes, lines, key)
        for section in kind.writes:
            about = ABOUT.get(section)
            if about is not None and about not in written and about not in kind.writes:
                what = f"writes the {section} of the {about} and so reads"
                raise _explain_missing(kind, about, what, passes, lines, key)
        written.update(kind.writes)


def find_stale(
    pass_: type[Pass], altered: Collection[str], before: Iterable[type[Pass]]
) -> tuple[str, str] | None:
    """Find a section that a pass changed after another pass had made something from it.

    Args:
        pass_: The pass.
        altered: The sections of which the pass changed what was there.
        before: The passes that ran before it.

    Returns:
        The message and a hint; None if nothing is stale.  What the pass declares to write it makes
        anew, so that this is not stale.
    """
    for section in altered:
        for reader in before:
            stale = [other for other in reader.writes if other not in (section, *pass_.writes)]
            if section in reader.reads and stale:
                message = (
                    f"pass '{pass_.name}' changes the {section} after pass '{reader.name}' made "
                    f"the {stale[0]} from it"
                )
                return message, f"put '{pass_.name}' before '{reader.name}'"
    return None


def _explain_missing(
    kind: type[Pass],
    section: str,
    reads: str,
    passes: Sequence[type[Pass]],
    lines: Lines,
    key: Key,
) -> ConversionError:
    """Return the error for a section that is not written before a pass that needs it."""
    writers = [other.name for other in passes if section in other.writes and other is not kind]
    what = f"pass '{kind.name}' {reads} the {section}"
    if not writers:
        hint = "'urdf2mbs explain' lists what each pass writes; put such a pass before it"
        message = f"{what}, which no pass of this pipeline writes"
        return lines.error("need-not-given", message, key, hint)
    hint = f"put it after: 'after: {{{writers[0]}: {kind.name}}}', or so in 'pipeline'"
    return lines.error("wrong-order", f"{what}, which '{writers[0]}' writes only later", key, hint)
