"""Choose and order the passes of a config, and check that the order can work.

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
        config_key: The key of the config that names the pass, or its preset.
        config_lines: The line of each value of the config.
        swapped: Whether the pass replaces ours of the same name.
        named: Whether the config names the pass.
    """

    def __init__(
        self,
        entry: PassEntry,
        options: dict[str, Any],
        config_key: Key,
        config_lines: Lines,
        *,
        swapped: bool,
        named: bool,
    ) -> None:
        self.entry = entry
        self.options = options
        self.key = config_key
        self.swapped = swapped
        self.given = bool(options) or swapped or named
        """Whether the config names the pass or sets its options."""
        self._config_lines = config_lines
        if options:
            _ = self.pass_  # raises the faults of the options

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
        configured: Pass = typed(self.kind, self.options, self._config_lines, ("passes", self.name))
        return configured

    def add_defaults(self, options: dict[str, Any]) -> ConfiguredPass:
        """Return this pass with options beneath its own.

        Raises:
            ConfigError: The pass has no such option.
        """
        return ConfiguredPass(
            self.entry,
            merge_options(options, self.options),
            self.key,
            self._config_lines,
            swapped=self.swapped,
            named=self.given,
        )


def merge_options(defaults: Mapping[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options over defaults; blocks of keys are merged key by key, defaults first."""
    merged = {**defaults, **options}
    for key, default in defaults.items():
        if isinstance(default, Mapping) and isinstance(merged[key], Mapping):
            merged[key] = merge_options(default, merged[key])
    return merged


def resolve(config: Config, config_lines: Lines, plugins: Plugins) -> list[ConfiguredPass]:
    """Return the passes of a config, chosen, placed and with their options.

    Errors of single passes become faults of the lines.

    Raises:
        ConfigError: The pipeline as a whole cannot be resolved.
    """
    options: dict[str, dict[str, Any]] = {}
    if isinstance(config.pipeline, str):
        pass_names, options = expand_preset(config.pipeline, plugins, config_lines)
    else:
        pass_names = config.pipeline
    pass_names, config_keys = _place_passes(pass_names, config, plugins.passes, config_lines)
    for block_name, mentioned in (("passes", config.passes), ("swap", config.swap)):
        for pass_name in mentioned:
            if pass_name not in pass_names:
                config_lines.faults.append(
                    _unknown_pass_error(
                        pass_name, (block_name, pass_name), config_lines, plugins.passes, pass_names
                    )
                )
    configured_passes: list[ConfiguredPass] = []
    keys_by_pass: dict[str, Key] = {}
    for pass_name, config_key in zip(pass_names, config_keys, strict=True):
        with config_lines.gather():
            if pass_name not in plugins.passes:
                raise _unknown_pass_error(
                    pass_name, config_key, config_lines, plugins.passes, presets=plugins.presets
                )
            if pass_name in keys_by_pass:
                raise _doubled_pass_error(
                    pass_name, keys_by_pass[pass_name], config_key, config_lines
                )
            keys_by_pass[pass_name] = config_key
            configured_passes.append(
                ConfiguredPass(
                    _choose_entry(
                        pass_name,
                        plugins.passes[pass_name],
                        config.swap.get(pass_name),
                        config_lines,
                    ),
                    {**options.get(pass_name, {}), **config.passes.get(pass_name, {})},
                    config_key,
                    config_lines,
                    swapped=pass_name in config.swap,
                    named=pass_name in config.passes
                    or config_key[0] != "pipeline"
                    or not isinstance(config.pipeline, str),
                )
            )
    return configured_passes


def expand_preset(
    preset_name: str, plugins: Plugins, config_lines: Lines, extending: tuple[str, ...] = ()
) -> tuple[list[str], dict[str, dict[str, Any]]]:
    """Return the passes of a preset in their order, and the options that it sets.

    Args:
        preset_name: The preset.
        plugins: The plugins that are loaded.
        config_lines: The line of each value of the config.
        extending: The presets that extend this one.

    Raises:
        ConfigError: ``unknown-preset`` or ``preset-circle``.
    """
    if preset_name not in plugins.presets:
        message = f"there is no preset '{preset_name}'"
        if extending:
            message += f", which '{extending[-1]}' extends"
        hint = (
            nearest(preset_name, plugins.presets)
            or f"there are: {', '.join(sorted(plugins.presets))}"
        )
        raise config_lines.error("unknown-preset", message, ("pipeline",), hint)
    if preset_name in extending:
        raise config_lines.error(
            "preset-circle", f"preset '{preset_name}' extends itself", ("pipeline",)
        )
    preset = plugins.presets[preset_name]
    pass_names = join(preset.pipeline, plugins, (*extending, preset_name))
    options: dict[str, dict[str, Any]] = {}
    if preset.extends is not None:
        inherited, options = expand_preset(
            preset.extends, plugins, config_lines, (*extending, preset_name)
        )
        pass_names = pass_names or inherited
    pass_names, _ = _place_passes(pass_names, preset, plugins.passes, config_lines)
    for pass_name, option_values in preset.passes.items():
        options[pass_name] = {**options.get(pass_name, {}), **option_values}
    return pass_names, options


def list_method(plugins: Plugins) -> list[str]:
    """Return the core's passes, and those of our plugins, in the order of the method."""
    own_passes = [pass_name for pass_name, entries in plugins.passes.items() if entries[0].is_ours]
    core_passes = [pass_name for pass_name in own_passes if not plugins.passes[pass_name][0].after]
    return [
        pass_name
        for pass_name in join(core_passes, plugins, plugins.presets)
        if pass_name in own_passes
    ]


def join(pass_names: Iterable[str], plugins: Plugins, presets: Collection[str] = ()) -> list[str]:
    """Return a list of passes, with those of plugins at the places that they name.

    Args:
        pass_names: The passes, in their order.
        plugins: The plugins that are loaded.
        presets: The preset of the passes, and those that extend it.
    """
    joined = list(pass_names)
    waiting_passes = {
        pass_name: entries[0].after
        for pass_name, entries in plugins.passes.items()
        if entries[0].after and pass_name not in joined and entries[0].joins(presets)
    }
    while waiting_passes:
        # a pass comes after waiting ones, too, if they are among those that it names
        ready_passes = (
            pass_name
            for pass_name, predecessors in waiting_passes.items()
            if waiting_passes.keys().isdisjoint(predecessors)
        )
        pass_name = next(ready_passes, None) or next(iter(waiting_passes))
        nearest_predecessor, *more_predecessors = waiting_passes.pop(pass_name)
        if nearest_predecessor in joined:
            indices = [
                joined.index(predecessor)
                for predecessor in (nearest_predecessor, *more_predecessors)
                if predecessor in joined
            ]
            joined.insert(max(indices) + 1, pass_name)
    return joined


def check_order(
    passes: Sequence[ConfiguredPass], method_order: Sequence[str], config_lines: Lines
) -> None:
    """Check the places of the passes of a pipeline.

    Args:
        passes: The passes in their order.
        method_order: The names of our own passes in the order of the method, which they keep among
            themselves: each of them may use what all earlier ones have done.
        config_lines: The line of each value of the config.

    Raises:
        ConfigError: ``wrong-order`` or ``need-not-given``.
    """
    own_passes = [
        configured_pass for configured_pass in passes if configured_pass.name in method_order
    ]
    for earlier_pass, later_pass in pairwise(own_passes):
        if method_order.index(later_pass.name) < method_order.index(earlier_pass.name):
            message = (
                f"pass '{later_pass.name}' is placed after '{earlier_pass.name}', "
                f"which uses the result of '{later_pass.name}'"
            )
            hint = (
                f"put '{later_pass.name}' before '{earlier_pass.name}': our own passes keep the "
                "order of the method"
            )
            raise config_lines.error("wrong-order", message, later_pass.key, hint)
    written_sections: set[str] = set()
    for configured_pass in passes:
        missing_section = _find_missing(configured_pass.kind, written_sections)
        if missing_section is not None:
            raise _explain_missing(configured_pass, missing_section, passes, config_lines)
        written_sections.update(configured_pass.kind.writes)


class _MissingSection(msgspec.Struct, frozen=True):
    """A section that a pass needs."""

    section: str
    reason: str
    """What the pass does with it, as a verb with its object."""


def _find_missing(
    pass_class: type[Pass], written_sections: Collection[str]
) -> _MissingSection | None:
    """Return a section that a pass needs and no earlier pass has written."""
    for section in pass_class.reads:
        if section not in written_sections and section not in OPTIONAL:
            return _MissingSection(section, f"reads the {section}")
    for section in pass_class.writes:
        owner_section = ABOUT.get(section)
        if (
            owner_section is not None
            and owner_section not in written_sections
            and owner_section not in pass_class.writes
        ):
            return _MissingSection(
                owner_section,
                f"writes the {section} of the {owner_section} and so reads the {owner_section}",
            )
    return None


def _explain_missing(
    configured_pass: ConfiguredPass,
    missing_section: _MissingSection,
    passes: Sequence[ConfiguredPass],
    config_lines: Lines,
) -> ConfigError:
    """Return the error for a section that is not written before a pass that needs it."""
    message = f"pass '{configured_pass.name}' {missing_section.reason}"
    writing_passes = [
        later_pass.name
        for later_pass in passes
        if missing_section.section in later_pass.kind.writes and later_pass is not configured_pass
    ]
    if writing_passes:
        message += f", which '{writing_passes[0]}' writes only later"
        placing = f"after: {{{writing_passes[0]}: {configured_pass.name}}}"
        hint = f"put it after: '{placing}', or so in 'pipeline'"
        return config_lines.error("wrong-order", message, configured_pass.key, hint)
    message += ", which no pass of this pipeline writes"
    dependent_passes = _list_dependent(passes)
    hint = (
        "'urdf2mbs explain' lists what each pass writes; put such a pass before it, or leave out "
        f"what needs it: 'without: [{', '.join(dependent_passes)}]'"
    )
    return config_lines.error("need-not-given", message, configured_pass.key, hint)


def _list_dependent(passes: Sequence[ConfiguredPass]) -> list[str]:
    """Return the passes that have to be left out, as no pass writes a section that they need."""
    written_sections: set[str] = set()
    dependent_passes: list[str] = []
    for configured_pass in passes:
        if _find_missing(configured_pass.kind, written_sections) is None:
            written_sections.update(configured_pass.kind.writes)
        else:
            dependent_passes.append(configured_pass.name)
    return dependent_passes


def _place_passes(
    pass_names: list[str],
    config: Config | Preset,
    known_passes: Mapping[str, list[PassEntry]],
    config_lines: Lines,
) -> tuple[list[str], list[Key]]:
    """Leave out and put in passes, as a config or a preset states.

    Args:
        pass_names: The passes of the pipeline.
        config: Has ``without``, ``before`` and ``after``.
        known_passes: Every pass by name.
        config_lines: The line of each value of the config.

    Returns:
        The passes in their order, and the key of the config that names each.

    Raises:
        ConfigError: ``unknown-pass``.
    """
    is_preset = isinstance(config, Preset) or isinstance(config.pipeline, str)
    for pass_name in config.without:
        if pass_name not in pass_names:
            raise _unknown_pass_error(
                pass_name, ("without",), config_lines, known_passes, pass_names
            )
    pending_placements = [
        ("before", pass_name, placed_passes) for pass_name, placed_passes in config.before.items()
    ]
    pending_placements += [
        ("after", pass_name, placed_passes) for pass_name, placed_passes in config.after.items()
    ]
    moved_passes = {
        pass_name
        for _, _, placed_passes in pending_placements
        for pass_name in _as_list(placed_passes)
    }
    remaining = [
        (pass_name, ("pipeline", index))
        for index, pass_name in enumerate(pass_names)
        if pass_name not in config.without
        # a pass that names its place is moved; one that a list names twice is doubled
        and not (
            is_preset
            and pass_name in moved_passes
            and pass_name in known_passes
            and known_passes[pass_name][0].after
        )
    ]
    pass_names = [pass_name for pass_name, _ in remaining]
    config_keys: list[Key] = [config_key for _, config_key in remaining]
    while pending_placements:  # a pass may be placed beside one that is put in, too
        ready_placement = next(
            (placing for placing in pending_placements if placing[1] in pass_names), None
        )
        if ready_placement is None:
            placement_side, pass_name, _ = pending_placements[0]
            raise _unknown_pass_error(
                pass_name, (placement_side, pass_name), config_lines, known_passes, pass_names
            )
        pending_placements.remove(ready_placement)
        placement_side, pass_name, placed_passes = ready_placement
        insertion_index = pass_names.index(pass_name) + (placement_side == "after")
        pass_names[insertion_index:insertion_index] = _as_list(placed_passes)
        config_keys[insertion_index:insertion_index] = [(placement_side, pass_name)] * len(
            _as_list(placed_passes)
        )
    return pass_names, config_keys


def _as_list(pass_names: str | list[str]) -> list[str]:
    return [pass_names] if isinstance(pass_names, str) else pass_names


def _choose_entry(
    pass_name: str, entries: list[PassEntry], plugin_name: str | None, config_lines: Lines
) -> PassEntry:
    """Return the pass of a name: that of the plugin which ``swap`` names, or else ours."""
    entries_by_plugin = {entry.plugin: entry for entry in entries}
    if plugin_name is None:
        if not entries[0].is_ours and len(entries) > 1:
            message = f"plugins {' and '.join(entries_by_plugin)} each bring a pass '{pass_name}'"
            hint = f"say which: 'swap: {{{pass_name}: {entries[0].plugin}}}'"
            raise ConfigError("pass-ambiguous", message, hint=hint)
        return entries[0]
    if plugin_name not in entries_by_plugin:
        message = f"no plugin '{plugin_name}' brings a pass '{pass_name}'"
        hint = (
            nearest(plugin_name, entries_by_plugin)
            or f"those that do: {', '.join(entries_by_plugin)}"
        )
        raise config_lines.error("unknown-plugin", message, ("swap", pass_name), hint)
    return entries_by_plugin[plugin_name]


def _doubled_pass_error(
    pass_name: str, first_key: Key, second_key: Key, config_lines: Lines
) -> ConfigError:
    """Return the error for a pass that is in the pipeline twice, at the key that puts it in."""
    inserting_keys = [key for key in (first_key, second_key) if key[0] in ("before", "after")]
    faulty_key = (*inserting_keys, second_key)[0]
    return config_lines.error(
        "pass-doubled", f"pass '{pass_name}' is in the pipeline twice", faulty_key
    )


def _unknown_pass_error(
    pass_name: str,
    config_key: Key,
    config_lines: Lines,
    known_passes: Collection[str],
    pipeline_names: Collection[str] = (),
    *,
    presets: Collection[str] = (),
) -> ConfigError:
    """Return the error for a pass that is not known, or is not in the pipeline.

    Args:
        pass_name: The pass.
        config_key: The key of the config that names it.
        config_lines: The line of each value of the config.
        known_passes: Every known pass.
        pipeline_names: The passes of the pipeline.
        presets: The presets, one of which may be meant.
    """
    if pass_name in known_passes:
        message = f"pass '{pass_name}' is not in this pipeline"
        hint: str | None = "'pipeline', 'after' or 'before' puts it in"
    elif pass_name in presets:
        message = f"there is no pass '{pass_name}'"
        hint = f"a preset's name stands alone: 'pipeline: {pass_name}'"
    else:
        message = f"there is no pass '{pass_name}'"
        hint = (
            nearest(pass_name, [*pipeline_names, *known_passes]) or "'urdf2mbs explain' lists all"
        )
    return config_lines.error("unknown-pass", message, config_key, hint)
