"""The order of the passes: what each needs must be given before, and must still hold."""

from __future__ import annotations

from collections.abc import Sequence

from urdf2mbs.engine.config import Key, Lines
from urdf2mbs.engine.hookspecs import Pass


def check_order(
    passes: Sequence[Pass], lines: Lines | None = None, keys: Sequence[Key] | None = None
) -> None:
    """Every need must be given by an earlier pass and still hold; raises ConfigError.

    ``keys`` say where in the config each pass is named.
    """
    lines = lines or Lines()
    known = _Known(passes, lines)
    for pass_, at in zip(passes, keys or [()] * len(passes), strict=True):
        for token in (*pass_.needs, *pass_.changes):
            known.need(token, pass_, at)
        for token in pass_.changes:
            known.change(token, pass_)
        for token in pass_.gives:
            known.give(token, pass_, at)
    known.end()


class _Known:
    """What is known at one place of a pipeline, and what of it no longer holds."""

    def __init__(self, passes: Sequence[Pass], lines: Lines) -> None:
        self.lines = lines
        self.ever = {token: pass_.name for pass_ in reversed(passes) for token in pass_.gives}
        """Who first gives each token, here or later."""
        self.giver: dict[str, str] = {}
        self.sources: dict[str, set[str]] = {}
        """What each token was derived from, all the way."""
        self.stale: dict[str, tuple[str, str]] = {}
        """The tokens that no longer hold: who changed which of their sources."""

    def need(self, token: str, pass_: Pass, at: Key) -> None:
        if token not in self.ever:
            raise self.lines.error(
                "need-not-given",
                f"pass '{pass_.name}' needs '{token}', which no pass of this pipeline gives",
                at, "'urdf2mbs passes' lists what each pass gives; put one that does before it",
            )  # fmt: skip
        if token not in self.giver:
            giver = self.ever[token]
            raise self.lines.error(
                "wrong-order",
                f"pass '{pass_.name}' needs '{token}', which '{giver}' gives only later",
                at, f"put it after: 'after: {{{giver}: {pass_.name}}}', or so in 'pipeline'",
            )  # fmt: skip
        if token in self.stale:
            giver, (changer, source) = self.giver[token], self.stale[token]
            raise self.lines.error(
                "stale",
                f"pass '{pass_.name}' needs '{token}', which '{giver}' made from '{source}' "
                f"before pass '{changer}' changed that",
                at, f"put '{changer}' before '{giver}'",
            )  # fmt: skip

    def change(self, token: str, pass_: Pass) -> None:
        for other, sources in self.sources.items():
            if token in sources and other not in pass_.changes:
                self.stale.setdefault(other, (pass_.name, token))
        self.sources[token] |= self._sources(pass_) - {token}

    def give(self, token: str, pass_: Pass, at: Key) -> None:
        if token in self.giver and token not in self.stale:
            raise self.lines.error(
                "given-twice",
                f"passes '{self.giver[token]}' and '{pass_.name}' both give '{token}'",
                at, "leave one of them out of the pipeline",
            )  # fmt: skip
        self.stale.pop(token, None)
        self.giver[token] = pass_.name
        self.sources[token] = self._sources(pass_)

    def _sources(self, pass_: Pass) -> set[str]:
        tokens = {*pass_.needs, *pass_.changes}
        return tokens.union(*(self.sources[token] for token in tokens))

    def end(self) -> None:
        """What a pass made and another made stale would be written all the same."""
        for token, (changer, source) in reversed(self.stale.items()):
            raise self.lines.error(
                "stale",
                f"pass '{changer}' changes '{source}' after pass '{self.giver[token]}' made "
                f"'{token}' from it",
                hint=f"put '{changer}' before '{self.giver[token]}'",
            )
