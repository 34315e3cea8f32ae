"""Which passes a config means, in which order, and whether that order can work.

A preset is a list of passes.  Passes of plugins join it at the places that they name, and a config
leaves passes out and puts others before and after.  Two rules are checked of the result, from what
the passes declare:

* a section that a pass reads is written before, and
* so is the section that a written one belongs to: a posture is of joints.

``engine.contract`` checks what the passes really do.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any

import msgspec

from urdf2mbs.config.lines import Key, Lines
from urdf2mbs.config.load import typed
from urdf2mbs.config.model import Config, Preset
from urdf2mbs.engine.plugins import Plugins, load_pass
from urdf2mbs.engine.sections import ABOUT, OPTIONAL
from urdf2mbs.hookspecs import Pass, PassEntry
from urdf2mbs.messages.diagnostics import ConfigError, nearest


class ConfiguredPass:
    """A pass of a pipeline, with its options.

    Args:
        entry: The pass.
        options: Its options; they are checked at once.
        key: The key of the config that names the pass, or its preset.
        lines: The line of each value of the config.
        swapped: Whether the pass replaces ours of the same name.
        named: Whether the config names the pass.
    """

    def __init__(
        self,
        entry: PassEntry,
        options: dict[str, Any],
        key: Key,
        lines: Lines,
        *,
        swapped: bool,
        named: bool,
    ) -> None:
        self.entry = entry
        self.options = options
        self.key = key
        self.swapped = swapped
        self.given = bool(options) or swapped or named
        """Whether the config gives the pass options, or names the pass."""
        self._lines = lines
        if options:
            _ = self.pass_  # raises what is wrong with the options

    @property
    def name(self) -> str:
        """The name of the pass."""
        return self.entry.name

    @cached_property
    def kind(self) -> type[Pass]:
        """The class of the pass; imports its file."""
        return load_pass(self.entry)

    @cached_property
    def pass_(self) -> Pass:
        """The pass with its options; imports its file."""
        configured: Pass = typed(self.kind, self.options, self._lines, ("passes", self.name))
        return configured


def resolve(config: Config, lines: Lines, plugins: Plugins) -> list[ConfiguredPass]:
    """Return the passes of a config, chosen, placed and with their options.

    What is wrong with single passes becomes faults of the lines.

    Raises:
        ConfigError: The pipeline as a whole cannot be resolved.
    """
    options: dict[str, dict[str, Any]] = {}
    if isinstance(config.pipeline, str):
        names, options = expand_preset(config.pipeline, plugins, lines)
    else:
        names = config.pipeline
    names, keys = _place(names, config, plugins.passes, lines)
    for block, mentioned in (("passes", config.passes), ("swap", config.swap)):
        for name in mentioned:
            if name not in names:
                lines.faults.append(_unknown(name, (block, name), lines, plugins.passes, names))
    configured: list[ConfiguredPass] = []
    resolved: dict[str, Key] = {}
    for name, key in zip(names, keys, strict=True):
        with lines.gather():
            if name not in plugins.passes:
                raise _unknown(name, key, lines, plugins.passes, presets=plugins.presets)
            if name in resolved:
                raise _doubled(name, resolved[name], key, lines)
            resolved[name] = key
            configured.append(
                ConfiguredPass(
                    _choose(name, plugins.passes[name], config.swap.get(name), lines),
                    {**options.get(name, {}), **config.passes.get(name, {})},
                    key,
                    lines,
                    swapped=name in config.swap,
                    named=name in config.passes
                    or key[0] != "pipeline"
                    or not isinstance(config.pipeline, str),
                )
            )
    return configured


def expand_preset(
    name: str, plugins: Plugins, lines: Lines, extending: tuple[str, ...] = ()
) -> tuple[list[str], dict[str, dict[str, Any]]]:
    """Return the passes of a preset in their order, and the options that it sets.

    Args:
        name: The preset.
        plugins: The plugins that are loaded.
        lines: The line of each value of the config.
        extending: The presets that extend this one.

    Raises:
        ConfigError: ``unknown-preset`` or ``preset-circle``.
    """
    if name not in plugins.presets:
        message = f"there is no preset '{name}'"
        if extending:
            message += f", which '{extending[-1]}' extends"
        hint = nearest(name, plugins.presets) or f"there are: {', '.join(sorted(plugins.presets))}"
        raise lines.error("unknown-preset", message, ("pipeline",), hint)
    if name in extending:
        raise lines.error("preset-circle", f"preset '{name}' extends itself", ("pipeline",))
    preset = plugins.presets[name]
    names = join(preset.pipeline, plugins, (*extending, name))
    options: dict[str, dict[str, Any]] = {}
    if preset.extends is not None:
        inherited, options = expand_preset(preset.extends, plugins, lines, (*extending, name))
        names = names or inherited
    names, _ = _place(names, preset, plugins.passes, lines)
    for pass_name, values in preset.passes.items():
        options[pass_name] = {**options.get(pass_name, {}), **values}
    return names, options


def list_method(plugins: Plugins) -> list[str]:
    """Return the core's passes, and those of our plugins, in the order of the method."""
    ours = [name for name, entries in plugins.passes.items() if entries[0].is_ours]
    core = [name for name in ours if not plugins.passes[name][0].after]
    return [name for name in join(core, plugins, plugins.presets) if name in ours]


def join(names: Iterable[str], plugins: Plugins, presets: Collection[str] = ()) -> list[str]:
    """Return a list of passes, with those of plugins at the places that they name.

    Args:
        names: The passes, in their order.
        plugins: The plugins that are loaded.
        presets: The preset of the passes, and those that extend it.
    """
    joined = list(names)
    waiting = {
        name: entries[0].after
        for name, entries in plugins.passes.items()
        if entries[0].after and name not in joined and entries[0].joins(presets)
    }
    while waiting:
        # a pass comes after waiting ones, too, if they are among those that it names
        ready = (name for name, after in waiting.items() if waiting.keys().isdisjoint(after))
        name = next(ready, None) or next(iter(waiting))
        first, *others = waiting.pop(name)
        if first in joined:
            indices = [joined.index(other) for other in (first, *others) if other in joined]
            joined.insert(max(indices) + 1, name)
    return joined


def check_order(passes: Sequence[ConfiguredPass], method: Sequence[str], lines: Lines) -> None:
    """Check the places of the passes of a pipeline.

    Args:
        passes: The passes in their order.
        method: The names of our own passes in the order of the method, which they keep among
            themselves: each of them may use what all earlier ones have done.
        lines: The line of each value of the config.

    Raises:
        ConfigError: ``wrong-order`` or ``need-not-given``.
    """
    ours = [step for step in passes if step.name in method]
    for earlier, later in pairwise(ours):
        if method.index(later.name) < method.index(earlier.name):
            message = (
                f"pass '{later.name}' is placed after '{earlier.name}', "
                f"which uses the result of '{later.name}'"
            )
            hint = (
                f"put '{later.name}' before '{earlier.name}': our own passes keep the order of "
                "the method"
            )
            raise lines.error("wrong-order", message, later.key, hint)
    written: set[str] = set()
    for step in passes:
        need = _find_missing(step.kind, written)
        if need is not None:
            raise _explain_missing(step, need, passes, lines)
        written.update(step.kind.writes)


class _Need(msgspec.Struct, frozen=True):
    """A section that a pass needs."""

    section: str
    reason: str
    """What the pass does with it, as a verb with its object."""


def _find_missing(kind: type[Pass], written: Collection[str]) -> _Need | None:
    """Return a section that a pass needs and no earlier pass has written."""
    for section in kind.reads:
        if section not in written and section not in OPTIONAL:
            return _Need(section, f"reads the {section}")
    for section in kind.writes:
        owner = ABOUT.get(section)
        if owner is not None and owner not in written and owner not in kind.writes:
            return _Need(owner, f"writes the {section} of the {owner} and so reads the {owner}")
    return None


def _explain_missing(
    step: ConfiguredPass, need: _Need, passes: Sequence[ConfiguredPass], lines: Lines
) -> ConfigError:
    """Return the error for a section that is not written before a pass that needs it."""
    message = f"pass '{step.name}' {need.reason}"
    writers = [
        other.name for other in passes if need.section in other.kind.writes and other is not step
    ]
    if writers:
        message += f", which '{writers[0]}' writes only later"
        hint = f"put it after: 'after: {{{writers[0]}: {step.name}}}', or so in 'pipeline'"
        return lines.error("wrong-order", message, step.key, hint)
    message += ", which no pass of this pipeline writes"
    dependent = _list_dependent(passes)
    hint = (
        "'urdf2mbs explain' lists what each pass writes; put such a pass before it, or leave out "
        f"what needs it: 'without: [{', '.join(dependent)}]'"
    )
    return lines.error("need-not-given", message, step.key, hint)


def _list_dependent(passes: Sequence[ConfiguredPass]) -> list[str]:
    """Return the passes that have to be left out, as no pass writes what they need."""
    written: set[str] = set()
    dependent: list[str] = []
    for step in passes:
        if _find_missing(step.kind, written) is None:
            written.update(step.kind.writes)
        else:
            dependent.append(step.name)
    return dependent


def _place(
    names: list[str], config: Config | Preset, known: Mapping[str, list[PassEntry]], lines: Lines
) -> tuple[list[str], list[Key]]:
    """Leave out and put in passes, as a config or a preset states.

    Args:
        names: The passes of the pipeline.
        config: Has ``without``, ``before`` and ``after``.
        known: Every pass by name.
        lines: The line of each value of the config.

    Returns:
        The passes in their order, and the key of the config that names each.

    Raises:
        ConfigError: ``unknown-pass``.
    """
    is_preset = isinstance(config, Preset) or isinstance(config.pipeline, str)
    for name in config.without:
        if name not in names:
            raise _unknown(name, ("without",), lines, known, names)
    waiting = [("before", name, new) for name, new in config.before.items()]
    waiting += [("after", name, new) for name, new in config.after.items()]
    moved = {name for _, _, new in waiting for name in _as_list(new)}
    names = [
        name
        for name in names
        if name not in config.without
        # a pass that names its place is moved; one that a list names twice is doubled
        and not (is_preset and name in moved and name in known and known[name][0].after)
    ]
    keys: list[Key] = [("pipeline", index) for index in range(len(names))]
    while waiting:  # a pass may be placed beside one that is put in, too
        ready = next((placing for placing in waiting if placing[1] in names), None)
        if ready is None:
            side, name, _ = waiting[0]
            raise _unknown(name, (side, name), lines, known, names)
        waiting.remove(ready)
        side, name, new = ready
        index = names.index(name) + (side == "after")
        names[index:index] = _as_list(new)
        keys[index:index] = [(side, name)] * len(_as_list(new))
    return names, keys


def _as_list(names: str | list[str]) -> list[str]:
    return [names] if isinstance(names, str) else names


def _choose(name: str, entries: list[PassEntry], plugin: str | None, lines: Lines) -> PassEntry:
    """Return the pass of a name: that of the plugin which ``swap`` names, or else ours."""
    by_plugin = {entry.plugin: entry for entry in entries}
    if plugin is None:
        if not entries[0].is_ours and len(entries) > 1:
            message = f"plugins {' and '.join(by_plugin)} each bring a pass '{name}'"
            hint = f"say which: 'swap: {{{name}: {entries[0].plugin}}}'"
            raise ConfigError("pass-ambiguous", message, hint=hint)
        return entries[0]
    if plugin not in by_plugin:
        message = f"no plugin '{plugin}' brings a pass '{name}'"
        hint = nearest(plugin, by_plugin) or f"those that do: {', '.join(by_plugin)}"
        raise lines.error("unknown-plugin", message, ("swap", name), hint)
    return by_plugin[plugin]


def _doubled(name: str, first: Key, second: Key, lines: Lines) -> ConfigError:
    """Return the error for a pass that is in the pipeline twice, at the key that puts it in."""
    inserting = [key for key in (first, second) if key[0] in ("before", "after")]
    key = (*inserting, second)[0]
    return lines.error("pass-doubled", f"pass '{name}' is in the pipeline twice", key)


def _unknown(
    name: str,
    key: Key,
    lines: Lines,
    known: Collection[str],
    names: Collection[str] = (),
    *,
    presets: Collection[str] = (),
) -> ConfigError:
    """Return the error for a pass that is not known, or is not in the pipeline.

    Args:
        name: The pass.
        key: The key of the config that names it.
        lines: The line of each value of the config.
        known: Every known pass.
        names: The passes of the pipeline.
        presets: The presets, one of which may be meant.
    """
    if name in known:
        message = f"pass '{name}' is not in this pipeline"
        hint: str | None = "'pipeline', 'after' or 'before' puts it in"
    elif name in presets:
        message = f"there is no pass '{name}'"
        hint = f"a preset's name stands alone: 'pipeline: {name}'"
    else:
        message = f"there is no pass '{name}'"
        hint = nearest(name, [*names, *known]) or "'urdf2mbs explain' lists all"
    return lines.error("unknown-pass", message, key, hint)
