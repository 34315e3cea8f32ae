"""Collects what plugins report of a finished conversion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion, Summary
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.messages.tracebacks import FAILURES, describe_exception, find_line


def of_plugins(conversion: Conversion) -> Summary:
    """Return the summaries of all plugins as one; warn of those that fail."""
    merged = Summary()
    for impl in reversed(conversion.hook.urdf2mbs_summary.get_hookimpls()):
        try:
            summary = impl.function(**dict.fromkeys(impl.argnames, conversion))
            if summary is not None:
                fields = {name: getattr(summary, name) for name in Summary.__struct_fields__}
                summary = msgspec.convert(fields, Summary)
        except FAILURES as error:
            _warn_of_failure(impl, error, conversion)
            continue
        if summary is not None:
            merged.lines += summary.lines
            merged.uses |= summary.uses
            merged.tables += summary.tables
            merged.next_steps += summary.next_steps
    return merged


def _warn_of_failure(impl: Any, error: BaseException, conversion: Conversion) -> None:
    """Warn, once, of a plugin whose summary fails.

    Args:
        impl: The function of the plugin, as pluggy has it.
        error: Its exception.
        conversion: The conversion that was to be summarised.
    """
    message = f"plugin '{impl.plugin_name}': urdf2mbs_summary failed: {describe_exception(error)}"
    # a page and the command line may both ask for the summary
    if message not in [diagnostic.message for diagnostic in conversion.diagnostics]:
        file = getattr(impl.plugin, "__file__", None)
        line = find_line(Path(file), error) if file else None
        conversion.diagnostics.append(
            Diagnostic("warning", "plugin-summary", message, file=file, line=line)
        )
