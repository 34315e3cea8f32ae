"""The generated pages of the reference: commands, config, passes, hooks, Python API.

They come from the program itself, so they cannot be stale.
"""

from __future__ import annotations

import argparse
import inspect
import json
import posixpath
import re
from importlib import import_module
from pathlib import Path, PurePosixPath
from typing import Any

from make_reference import make_table  # beside this file

from urdf2mbs import hookspecs, plugin
from urdf2mbs.commands import list_commands, parser
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.hookspecs import GROUP
from urdf2mbs_setup.commands.schema import make_schema

DOCS = Path(__file__).resolve().parent
CODE = "```"
#: Pages beside the folder docs, and their names on the site.
ROOT_PAGES = {
    "../README.md": "index.md",
    "../CONTRIBUTING.md": "contributing.md",
    "../CHANGELOG.md": "changelog.md",
}


def on_files(files: Any, config: Any) -> Any:
    """MkDocs calls this with all pages: add the generated pages."""
    from mkdocs.structure.files import File

    for name, text in pages().items():
        files.append(File.generated(config, name, content=text))
    return files


def on_config(config: Any) -> Any:
    """MkDocs calls this first: the reference gets the page of each pass."""
    passes = sorted(file.stem for file in (DOCS / "passes").glob("*.md"))
    reference = next(part["Reference"] for part in config.nav if "Reference" in part)
    reference.append({"Each pass": [{name: f"passes/{name}.md"} for name in passes]})
    return config


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Add a pass's options to its page; drop words for tests from code blocks, and links to files
    outside docs/."""
    if page.file.src_uri.startswith("passes/"):
        told = "\n".join(_options(PurePosixPath(page.file.src_uri).stem))
        method = re.search(r"^\*\*Method\*\*.*\n", markdown, re.MULTILINE)
        assert method, page.file.src_uri
        markdown = f"{markdown[: method.end()]}\n{told}\n{markdown[method.end() :]}"
    markdown = re.sub(r"^( *```\w+) .+$", r"\1", markdown, flags=re.MULTILINE)
    here = posixpath.dirname(page.file.src_uri)

    def link(found: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(here, found[2]))
        if target in ROOT_PAGES:
            page = posixpath.relpath(ROOT_PAGES[target], here or ".")
            return f"[{found[1]}]({page}{found[3] or ''})"
        outside = target.startswith("../")
        outside = outside or found[2].startswith(("urdf2mbs/", "plugins", "tests"))  # of the README
        outside = outside or found[2].endswith((".json", ".cff", "LICENSE", "SECURITY.md"))
        return found[1].replace("`", "") if outside else found[0]

    return re.sub(r"(?<!!)\[([^\]]+)\]\(([^):#]+)(#[^)]*)?\)", link, markdown)


def _of_the_root(name: str) -> str:
    """A page that lies beside the folder docs, such as the README, as a page of the site."""
    text = (DOCS.parent / name).read_text("utf-8").replace("](docs/", "](")
    text = text.replace("](CONTRIBUTING.md)", "](contributing.md)")
    return text.replace("](CHANGELOG.md)", "](changelog.md)")


def pages() -> dict[str, str]:
    """The generated pages, by name."""
    return {
        "index.md": _of_the_root("README.md"),
        "contributing.md": _of_the_root("CONTRIBUTING.md"),
        "changelog.md": _of_the_root("CHANGELOG.md"),
        "reference/commands.md": _commands(),
        "reference/config.schema.json": json.dumps(make_schema(Plugins(installed=False)), indent=2),
        "reference/passes.md": _passes(),
        "reference/hooks.md": _hooks(),
        "reference/plugin-api.md": _door(),
        "reference/plugins.md": _plugins(),
    }


def _door() -> str:
    """Return the page of the names that a plugin imports, by subject."""
    lines = [
        "# Plugin API",
        "",
        "A plugin imports from `urdf2mbs.plugin`; our own plugins import nothing else "
        "of the core. A name keeps its meaning within one version of this API, which is "
        f"{plugin.VERSION}.",
    ]
    for title, modules in plugin.EXPORTS.items():
        lines += ["", f"## {title}", "", "| name | what it is |", "|---|---|"]
        for module, names in modules.items():
            for name in names:
                original, _, renamed = name.partition(" as ")
                value = getattr(import_module(f"urdf2mbs.{module}"), original)
                lines.append(f"| `{renamed or original}` | {_describe(value)} |")
    lines += ["", "## Modules", "", "| name | what is in it |", "|---|---|"]
    for name, module in plugin.MODULES.items():
        lines.append(f"| `{name}` | {_describe(import_module(f'urdf2mbs.{module}'))} |")
    return "\n".join([*lines, ""])


def _describe(value: object) -> str:
    """Return the first paragraph about a class, function or module; of a short constant, it."""
    if inspect.isclass(value) or inspect.isfunction(value) or inspect.ismodule(value):
        text = (inspect.getdoc(value) or "").partition("\n\n")[0]
        return " ".join(text.split()).replace("``", "`").replace("|", "\\|")
    return f"`{value!r}`".replace("|", "\\|") if len(repr(value)) < 60 else ""


def _plugins() -> str:
    """What each plugin has, and which of its files to open first."""
    lines = ["# Plugins", "", "Everything that is not the method is a plugin, and uses the public "
             "plugin API, as yours does."]  # fmt: skip
    for file in sorted((DOCS.parent / "plugins").glob("*/README.md")):
        lines += ["", f"#{file.read_text('utf-8').strip()}".replace("](../../docs/", "](../")]
    return "\n".join([*lines, ""])


def _commands() -> str:
    told = "[Exit codes](../diagnostics.md#exit-codes) are the same for all commands."
    lines = ["# Commands", "", f"`-` is standard input or output. {told}", ""]
    action = next(a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    for name, command in action.choices.items():
        does, module = list_commands()[name].does, list_commands()[name].module
        whose = _whose(module.partition(".")[0].removeprefix(f"{GROUP}_"))
        end = "" if does.endswith("?") else "."
        lines += [f"## {name}", "", f"{does[0].upper()}{does[1:]}{end} {whose}", "", f"{CODE}sh"]
        examples = import_module(module).EXAMPLES
        lines += [*examples, CODE, "", "| option | |", "|---|---|"]
        for one in command._actions:
            if one.dest == "help":
                continue
            words = ", ".join(one.option_strings) or str(one.metavar or one.dest)
            value = one.metavar or ("\\|".join(one.choices) if one.choices else "")
            value = f" {value}" if value and one.option_strings and one.nargs != 0 else ""
            told = (one.help or "") % {**vars(one), "prog": "urdf2mbs"} if one.help else ""
            lines.append(f"| `{words}{value}` | {told} |".replace("\\|", "/"))
        lines.append("")
    return "\n".join(lines)


def _options(name: str) -> list[str]:
    """What a pass reads and writes, and its options."""
    (found, *_) = Plugins(installed=False).passes[name]
    reads, writes = (
        ", ".join(f"`{section}`" for section in sections) or "nothing"
        for sections in (found.load().reads, found.load().writes)
    )
    told = [f"{_whose(found.plugin)} Reads {reads}; writes {writes}.", ""]
    options = make_schema(Plugins(installed=False))["$defs"][f"{name}.{found.load().__name__}"]
    return told + (
        make_table("option", options) if options["properties"] else ["It has no options."]
    )


def _whose(plugin: str) -> str:
    return "Of the core." if plugin == GROUP else f"Of the plugin {plugin}."


def _passes() -> str:
    lines = ["# Passes", "", "All built-in passes by name. "
             "[What a pass declares](../passes.md) lists them by what they change.", "",
             "| pass | | plugin | reads | writes |", "|---|---|---|---|---|"]  # fmt: skip
    for name, found in sorted(Plugins(installed=False).passes.items()):
        kind = found[0].load()
        row = " | ".join(
            ", ".join(f"`{section}`" for section in sections) or "-"
            for sections in (kind.reads, kind.writes)
        )
        plugin = "" if found[0].is_core else found[0].plugin
        lines.append(f"| [{name}](../passes/{name}.md) | {kind.summary()} | {plugin} | {row} |")
    return "\n".join([*lines, ""])


def _hooks() -> str:
    told = (
        "A hook takes only the arguments that it names. [Examples](../hooks.md) show some at work."
    )
    lines = ["# Hooks", "", f"A plugin implements hooks with `hookimpl`. {told}", ""]
    for name, hook in vars(hookspecs).items():
        if name.startswith("urdf2mbs_"):
            lines += _function(name, hook)
    return "\n".join(lines)


def _list_arguments(section: re.Match[str]) -> str:
    """Return the section Args of a docstring as a list."""
    return re.sub(r"^ {4}(\w+): ", r"- `\1`: ", section[1], flags=re.MULTILINE)


def _function(name: str, function: Any) -> list[str]:
    parameters = [
        re.sub(r": '([^']*)'", r": \1", str(one))  # an annotation is a text there
        for one in inspect.signature(function).parameters.values()
    ]
    words = ",\n    ".join(parameters)
    called = f"{function.__name__}(\n    {words},\n)" if words else f"{function.__name__}()"
    text = inspect.getdoc(function) or ""
    text = re.sub(r"^Args:\n((?: {4}.*\n?)+)", _list_arguments, text, flags=re.MULTILINE)
    return [f"## {name}", "", f"{CODE}python", called, CODE, "", text.replace("``", "`"), ""]
