"""A config by the other presets: how many joints they would make."""

from __future__ import annotations

import argparse

import msgspec

from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.resolve import preset
from urdf2mbs.messages.diagnostics import ConfigError


def by_presets(config: Config, lines: Lines, arguments: argparse.Namespace) -> dict[str, Pipeline]:
    """The config by each preset but its own; plugins bring presets, too."""
    plugins = Pipeline(config, lines, installed_plugins=not arguments.no_plugins).plugins
    pipelines: dict[str, Pipeline] = {}
    for name in sorted(plugins.presets):
        if name == config.pipeline:
            continue
        there = set(preset(name, plugins, lines)[0])
        beside = [*config.after.items(), *config.before.items()]
        for _ in beside:  # what is put beside a pass may have others beside it
            for key, new in beside:
                if key in there:
                    there.update([new] if isinstance(new, str) else new)
        other = msgspec.structs.replace(
            config, pipeline=name,
            after={key: new for key, new in config.after.items() if key in there},
            before={key: new for key, new in config.before.items() if key in there},
            without=[key for key in config.without if key in there],
            swap={key: value for key, value in config.swap.items() if key in there},
            passes={key: value for key, value in config.passes.items() if key in there},
        )  # fmt: skip
        try:
            pipelines[name] = Pipeline(other, lines, installed_plugins=not arguments.no_plugins)
        except ConfigError:
            continue  # what the config says does not suit this preset
    return pipelines
