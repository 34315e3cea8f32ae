"""Which passes a config means, from which plugin, in which order, and with which options."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from typing import Any

from urdf2mbs.config.model import Config, Key, Lines, Preset, typed
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.registered import Registered
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError, nearest


class Configured:
    """A pass of a pipeline, with its options."""

    def __init__(
        self, registered: Registered, options: dict[str, Any], at: Key, lines: Lines,
        *, swapped: bool, named: bool,
    ) -> None:  # fmt: skip
        self.registered = registered
        self.options = options
        self.at = at
        """The place in the config that names the pass, or its preset."""
        self.swapped = swapped
        """True if the pass replaces the built-in pass of its name."""
        self.given = bool(options) or swapped or named
        """True if the config gives the pass options, or names the pass."""
        self._lines = lines
        if options:
            _ = self.pass_  # raises what is wrong with the options

    @property
    def name(self) -> str:
        return self.registered.name

    @cached_property
    def pass_(self) -> Pass:
        """The pass with its options; imports its file."""
        made: Pass = typed(self.registered.kind, self.options, self._lines, ("passes", self.name))
        return made


def resolve(config: Config, lines: Lines, plugins: Plugins) -> list[Configured]:
    """The passes of a config, chosen, placed and with their options.

    What is wrong with single passes becomes faults of the lines.  Raises ConfigError.
    """
    known = plugins.passes
    options: dict[str, dict[str, Any]] = {}
    if isinstance(config.pipeline, str):
        names, options = preset(config.pipeline, plugins, lines)
    else:
        names = config.pipeline
    names, keys = _place(names, config, known, lines)
    preset_alone = isinstance(config.pipeline, str)
    for key, mentioned in (("passes", config.passes), ("swap", config.swap)):
        for name in mentioned:
            if name not in names:
                lines.faults.append(_unknown(lines, (key, name), name, known, names))
    configured: list[Configured] = []
    seen: set[str] = set()
    for name, at in zip(names, keys, strict=True):
        with lines.gather():
            if name not in known:
                hint = f"a preset's name stands alone: 'pipeline: {name}'"
                raise _unknown(lines, at, name, known, hint=hint if name in plugins.presets else "")
            if name in seen:
                mine = [
                    key for key in (keys[names.index(name)], at) if key[0] in ("before", "after")
                ]
                raise lines.error(
                    "pass-doubled", f"pass '{name}' is in the pipeline twice", (*mine, at)[0]
                )
            seen.add(name)
            chosen = _choose(name, known[name], config.swap.get(name), lines)
            given = {**options.get(name, {}), **config.passes.get(name, {})}
            configured.append(Configured(
                chosen, given, at, lines, swapped=name in config.swap,
                named=name in config.passes or at[0] != "pipeline" or not preset_alone,
            ))  # fmt: skip
    return configured


def preset(
    name: str, plugins: Plugins, lines: Lines, below: tuple[str, ...] = ()
) -> tuple[list[str], dict[str, dict[str, Any]]]:
    """The passes of a preset in their order, and the options that it sets.

    ``below`` are the presets that extend this one.
    """
    if name not in plugins.presets:
        raise lines.error(
            "unknown-preset",
            f"there is no preset '{name}'" + (f", which '{below[-1]}' extends" if below else ""),
            ("pipeline",),
            nearest(name, plugins.presets) or f"there are: {', '.join(sorted(plugins.presets))}",
        )
    if name in below:
        raise lines.error("preset-circle", f"preset '{name}' extends itself", ("pipeline",))
    found = plugins.presets[name]
    names = plugins.join(found.pipeline, (*below, name))
    options: dict[str, dict[str, Any]] = {}
    if found.extends is not None:
        others, options = preset(found.extends, plugins, lines, (*below, name))
        names = names or others
    names, _ = _place(names, found, plugins.passes, lines)
    for pass_, given in found.passes.items():
        options[pass_] = {**options.get(pass_, {}), **given}
    return names, options


def _place(
    names: list[str], config: Config | Preset, known: Mapping[str, Any], lines: Lines
) -> tuple[list[str], list[Key]]:
    """The pipeline without what the config leaves out, and with what the config puts ``before``
    and ``after`` its passes; and where in the config each pass is named."""
    is_preset = isinstance(config, Preset) or isinstance(config.pipeline, str)
    for name in config.without:
        if name not in names:
            raise _unknown(lines, ("without",), name, known, names)
    waiting = [("before", name, new) for name, new in config.before.items()]
    waiting += [("after", name, new) for name, new in config.after.items()]
    moved = {pass_ for _, _, new in waiting for pass_ in _listed(new)}
    names = [
        name
        for name in names
        if name not in config.without
        # a pass that says its place is moved; one that a list names twice is doubled
        and not (name in moved and name in known and known[name][0].after and is_preset)
    ]
    keys: list[Key] = [("pipeline", n) for n in range(len(names))]
    while waiting:  # a pass may stand beside one that is put in itself
        ready = next((one for one in waiting if one[1] in names), None)
        if ready is None:
            where, name, _ = waiting[0]
            raise _unknown(lines, (where, name), name, known, names)
        waiting.remove(ready)
        where, name, new = ready
        at = names.index(name) + (where == "after")
        names[at:at] = _listed(new)
        keys[at:at] = [(where, name)] * len(_listed(new))
    return names, keys


def _listed(new: str | list[str]) -> list[str]:
    return [new] if isinstance(new, str) else new


def _choose(name: str, offered: list[Registered], plugin: str | None, lines: Lines) -> Registered:
    by_plugin = {registered.plugin: registered for registered in offered}
    if plugin is None and not offered[0].is_ours and len(offered) > 1:
        raise ConfigError(
            "pass-ambiguous", f"plugins {' and '.join(by_plugin)} each bring a pass '{name}'",
            hint=f"say which: 'swap: {{{name}: {offered[0].plugin}}}'",
        )  # fmt: skip
    if plugin is not None and plugin not in by_plugin:
        raise lines.error(
            "unknown-plugin", f"no plugin '{plugin}' brings a pass '{name}'", ("swap", name),
            nearest(plugin, by_plugin) or f"those that do: {', '.join(by_plugin)}",
        )  # fmt: skip
    # a built-in pass stands before those of plugins
    return offered[0] if plugin is None else by_plugin[plugin]


def _unknown(
    lines: Lines, at: Key, name: str, known: Collection[str], names: Collection[str] = (),
    hint: str = "",
) -> ConfigError:  # fmt: skip
    """The error for a pass that is not ``known``, or is not among the ``names`` of a pipeline."""
    if name in known:
        message = f"pass '{name}' is not in this pipeline"
        hint = "'pipeline', 'after' or 'before' puts it in"
    else:
        message = f"there is no pass '{name}'"
        hint = hint or nearest(name, [*names, *known]) or "'urdf2mbs explain' lists all"
    return lines.error("unknown-pass", message, at, hint)
