"""`explain`: every known pass, one pass, or the passes of a config, without running them.

Without a name: every known pass, a line each.  Of a pass: its place in each
preset, its options, what it reads and writes, and where it comes from.  Of a
config: its passes in their order, with all that it changes; -v shows the rest.
Converts nothing.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    ALONE,
    Config,
    ConfigError,
    ConfiguredPass,
    Lines,
    Pass,
    PassEntry,
    Pipeline,
    Plugins,
    add_fields,
    add_json,
    add_running,
    counted,
    is_file,
    is_folder,
    list_method,
    load_pass,
    near,
    nearest,
    path,
    print_json,
    read_robot_file,
    robot_or_config,
    version_of,
)
from urdf2mbs_setup.options import Option, list_inner_structs, list_options

#: The meaning of "the method" in the summaries of passes.
METHOD = (
    '"The method" is Appendix A, "URDF to MBS Converter", of the thesis on gait controllers in\n'
    "Robotran that urdf2mbs follows; the pages in docs/passes quote it, pass by pass."
)

EXAMPLES = (
    "urdf2mbs explain",
    "urdf2mbs explain lump-fixed",
    "urdf2mbs explain robot.yaml -v",
    "urdf2mbs explain robot.urdf --pipeline compact",
    "urdf2mbs explain our-pass --plugin our_passes.py",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument(
        "config",
        type=path,
        metavar="CONFIG.yaml",
        nargs="?",
        help="or the name of a pass; or a .urdf, .xacro or MJCF file, with the options below; "
        "without: every known pass",
    )
    add_json(command)
    add_running(command)
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    """Explain all passes, one pass, or the passes of a config."""
    argument: Path | None = arguments.config
    if argument is None:
        return _list_all(arguments)
    word = str(argument)
    # A pass and a folder may have the same name, such as 'project'.
    is_word = argument.suffix == "" and len(argument.parts) == 1 and word != "-"
    if is_word and not is_file(argument):
        plugins = _load_plugins(arguments)
        if word in plugins.passes:
            return _explain_pass(word, plugins, arguments)
        if ":" not in word and not is_folder(argument):
            raise _make_unknown_error(word, plugins)
    return _explain_config(arguments)


def _load_plugins(arguments: argparse.Namespace) -> Plugins:
    """Return the plugins of a command line without a config."""
    plugin_files = [Path(file) for file in arguments.plugins or ()]
    plugins = Plugins(plugin_files, installed=not arguments.no_plugins)
    print_broken_plugins(plugins)
    return plugins


def _make_unknown_error(word: str, plugins: Plugins) -> ConfigError:
    """Return the error for a word that is neither a file nor a pass."""
    if word in plugins.presets:
        message = f"'{word}' is a preset, not a pass and not a file"
        hint = f"urdf2mbs explain ROBOT.urdf --pipeline {word} lists its passes"
        return ConfigError("unknown-pass", message, hint=hint)
    config_names = [file.name for file in Path().glob("*.y*ml")]
    hint = nearest(word, [*plugins.passes, *config_names]) or (
        "urdf2mbs explain lists the passes; for those of a plugin's file, add --plugin FILE.py"
    )
    return ConfigError("unknown-pass", f"'{word}' is neither a file nor a pass", hint=hint)


# --- a config ---


def _explain_config(arguments: argparse.Namespace) -> int:
    """Print the settings and passes of a config or robot."""
    config, lines = robot_or_config(arguments)
    config = _first_of_sweep(config, lines, arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    print_broken_plugins(pipeline.plugins)
    if lines.file is None:
        read_robot_file(pipeline.settings.source)  # only to raise its errors
    if arguments.json:
        print_json(
            [
                {
                    **export_pass(step.entry),
                    "swapped": step.swapped,
                    "options": step.pass_,
                }
                for step in pipeline.passes
            ]
        )
        return 0
    settings = pipeline.settings
    print(f"source  {settings.source}\noutput  {settings.output}\nbase    {settings.config.base}")
    for package_name, folder in settings.packages.items():
        print(f"package {package_name} = {folder}")
    for argument_name, argument_value in settings.xacro_args.items():
        print(f"arg     {argument_name} := {argument_value}")
    if not arguments.verbose:
        print()
    name_width = max((len(step.name) for step in pipeline.passes), default=0)
    for pass_number, step in enumerate(pipeline.passes, start=1):
        if arguments.verbose:
            print(f"\n{pass_number}. {step.name}: {step.pass_.summary()}")
        else:
            print(_format_line(f"{pass_number:2}. {step.name:{name_width}}", step.pass_.summary()))
        for title, description in _describe_step(pipeline, step, verbose=arguments.verbose):
            print(f"    {title:8} {description}")
    print(f"\n{METHOD}" if arguments.verbose else "\n-v shows what each pass reads and writes")
    return 0


def _describe_step(
    pipeline: Pipeline, step: ConfiguredPass, *, verbose: bool
) -> Iterator[tuple[str, str]]:
    """Yield the lines of a pass in a config, as title and text.

    Args:
        pipeline: The passes of the config.
        step: The pass, with its options.
        verbose: Yield all lines; else those that differ from the defaults of urdf2mbs.
    """
    pass_, entry = step.pass_, step.entry
    rivals = [
        rival
        for rival in pipeline.plugins.passes.get(pass_.name, [])
        if rival.plugin != entry.plugin
    ]
    if verbose or rivals or not entry.is_ours:
        yield "from", describe_origin(entry) + (", by 'swap'" if step.swapped else "")
    for rival in rivals:
        yield "not", f"{describe_origin(rival)}: 'swap: {{{pass_.name}: {rival.plugin}}}'"
    if verbose:
        if entry.after:
            yield "after", ", ".join(entry.after)
        yield "reads", ", ".join(pass_.reads) or "-"
        yield "writes", ", ".join(pass_.writes) or "-"
    defaults = {option.name: option.default for option in list_options(type(pass_))}
    options = [
        f"{option_name}: {option_value!r}"
        for option_name, option_value in msgspec.to_builtins(pass_).items()
        if verbose or option_value != msgspec.to_builtins(defaults[option_name])
    ]
    if options or verbose:
        yield "options", ", ".join(options) or "-"


def _first_of_sweep(config: Config, lines: Lines, arguments: argparse.Namespace) -> Config:
    """Return the config of the first robot of a sweep; a config without a sweep as it is."""
    if config.sweep is None:
        return config
    hook = Plugins(installed=not arguments.no_plugins).hook
    robot_configs: list[tuple[Config, str]] | None = hook.urdf2mbs_expand_sweep(
        config=config, lines=lines
    )
    if robot_configs is None:
        message = "this config is a sweep, and no plugin expands sweeps"
        raise lines.error("plugin-missing", message, ("sweep",), "install urdf2mbs whole")
    first_config, values_text = robot_configs[0]
    if not arguments.json:
        count = counted(len(robot_configs), "robot")
        print(f"sweep   {count}; this is the first: {values_text}")
    return first_config


# --- one pass ---


def _explain_pass(pass_name: str, plugins: Plugins, arguments: argparse.Namespace) -> int:
    """Print all about a pass, and about those of other plugins that have its name."""
    entries = plugins.passes[pass_name]
    places = {
        preset: _describe_place(
            preset, pass_name, arguments.plugins or [], not arguments.no_plugins
        )
        for preset in plugins.presets
    }
    if arguments.json:
        print_json(
            [
                {
                    **export_pass(entry),
                    "options": list_options(load_pass(entry)),
                    "presets": places,
                }
                for entry in entries
            ]
        )
        return 0
    for index, entry in enumerate(entries):
        pass_class = load_pass(entry)
        print(f"{pass_name}: {pass_class.summary()}")
        print(f"  from     {describe_origin(entry)}")
        if index > 0:
            print(f"  used by  swap: {{{pass_name}: {entry.plugin}}}")
        else:
            preset_width = max(map(len, places), default=0)
            for preset_index, (preset, place) in enumerate(places.items()):
                title = "place" if preset_index == 0 else ""
                print(f"  {title:8} {preset:{preset_width}}  {place}")
        print(f"  reads    {', '.join(pass_class.reads) or '-'}")
        print(f"  writes   {', '.join(pass_class.writes) or '-'}")
        _print_options(pass_class)
    return 0


def _describe_place(preset: str, pass_name: str, plugin_files: list[str], installed: bool) -> str:
    """Describe the place of a pass among those of a preset.

    Args:
        preset: The preset.
        pass_name: The pass.
        plugin_files: Plugin files of the command line.
        installed: Whether plugins of installed packages are used.
    """
    config = Config(
        source="robot.urdf",
        pipeline=preset,
        plugins=[str(file) for file in plugin_files],
    )
    try:
        pipeline = Pipeline(config, Lines(), installed_plugins=installed)
    except ConfigError as error:
        return f"the preset cannot be used: {error.message}"
    pass_names = [step.name for step in pipeline.passes]
    if pass_name not in pass_names:
        return "not in it; a config adds it by 'after' or 'before'"
    index = pass_names.index(pass_name)
    predecessor = f", after '{pass_names[index - 1]}'" if index else ""
    return f"{index + 1} of {len(pass_names)}{predecessor}"


def _print_options(pass_class: type[Pass]) -> None:
    """Print the options of a pass, and the keys of objects in them."""
    options = list_options(pass_class)
    if not options:
        print("  options  -")
        return
    print("  options")
    for option in options:
        _print_option(option, "    ")
    for struct_class in list_inner_structs(pass_class):
        print(f"  each {struct_class.__name__}")
        for option in list_options(struct_class):
            _print_option(option, "    ")


def _print_option(option: Option, margin: str) -> None:
    """Print an option with its type and default, and below it its help."""
    default = "required" if option.required else f"default: {option.default_in_words}"
    print(f"{margin}{option.name}: {option.type}, {default}")
    if option.help:
        width = max(80, _get_terminal_width())
        indent = f"{margin}    "
        print(textwrap.fill(option.help, width, initial_indent=indent, subsequent_indent=indent))


# --- all passes ---


def _list_all(arguments: argparse.Namespace) -> int:
    """Print every known pass in the order of the method, and then those of other plugins."""
    plugins = _load_plugins(arguments)
    method_order = {pass_name: index for index, pass_name in enumerate(list_method(plugins))}
    entries = [entry for entries in plugins.passes.values() for entry in entries]
    entries.sort(key=lambda entry: (not entry.is_ours, method_order.get(entry.name, 0)))
    if arguments.json:
        print_json([export_pass(entry) for entry in entries])
        return 0
    name_width = max(len(entry.name) for entry in entries)
    for entry in entries:
        pass_class, padded_name = load_pass(entry), f"{entry.name:{name_width}}"
        if arguments.verbose:
            sections = (
                f"{', '.join(pass_class.reads) or '-'} -> {', '.join(pass_class.writes) or '-'}"
            )
            print(f"{padded_name}  {pass_class.summary()}")
            print(f"{'':{name_width}}  {sections}; {describe_origin(entry)}")
        else:
            print(
                _format_line(
                    padded_name, pass_class.summary(), "" if entry.is_ours else entry.plugin
                )
            )
    hint = "urdf2mbs explain PASS shows all of one pass; -v shows what each reads and writes"
    print(f"\n{METHOD}" if arguments.verbose else f"\n{hint}")
    return 0


def _format_line(padded_name: str, summary: str, plugin: str = "") -> str:
    """Format a pass as one line, shortened to the width of the terminal."""
    suffix = f" ({plugin})" if plugin else ""
    width = max(80, _get_terminal_width()) - len(padded_name) - 2 - len(suffix)
    return f"{padded_name}  {textwrap.shorten(summary, max(width, 20), placeholder=' ...')}{suffix}"


def _get_terminal_width() -> int:
    """Return the width of the terminal (letters)."""
    return shutil.get_terminal_size().columns


def print_broken_plugins(plugins: Plugins) -> None:
    """Print which plugins are left out, and why."""
    for plugin_error in plugins.broken:
        print(plugin_error, file=sys.stderr)


def describe_origin(entry: PassEntry) -> str:
    """Describe the plugin that a pass is from: name, package, version and file."""
    description = entry.plugin
    if entry.distribution not in ("", entry.plugin):
        description += f" of {entry.distribution}"
    if version := version_of(entry.distribution) if entry.distribution else "":
        description += f" {version}"
    return f"{description} ({near(Path(entry.source))})"


def export_pass(entry: PassEntry) -> dict[str, Any]:
    """Return a pass as data for JSON."""
    pass_class = load_pass(entry)
    return {
        "name": pass_class.name,
        "summary": pass_class.summary(),
        "plugin": entry.plugin,
        "package": entry.distribution,
        "version": version_of(entry.distribution) if entry.distribution else "",
        "file": entry.source,
        "reads": pass_class.reads,
        "writes": pass_class.writes,
    }
