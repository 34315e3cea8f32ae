"""Collects what plugins report of a finished conversion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion, Summary
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.messages.tracebacks import FAILURES, describe_exception, find_line


def of_plugins(conversion: Conversion, *, for_page: bool = False) -> Summary:
    """Return the summaries of all plugins as one; warn of those that fail.

    Args:
        conversion: A finished conversion.
        for_page: Whether the summary is for a page, with all tables.
    """
    merged_summary = Summary()
    arguments = {"conversion": conversion, "for_page": for_page}
    for hook_impl in reversed(conversion.hook.urdf2mbs_summary.get_hookimpls()):
        try:
            summary = hook_impl.function(**{name: arguments[name] for name in hook_impl.argnames})
            if summary is not None:
                summary_fields = {
                    field_name: getattr(summary, field_name)
                    for field_name in Summary.__struct_fields__
                }
                summary = msgspec.convert(summary_fields, Summary)
        except FAILURES as error:
            _warn_of_failure(hook_impl, error, conversion)
            continue
        if summary is not None:
            merged_summary.lines += summary.lines
            merged_summary.uses |= summary.uses
            merged_summary.tables += summary.tables
            merged_summary.next_steps += summary.next_steps
    return merged_summary


def _warn_of_failure(hook_impl: Any, error: BaseException, conversion: Conversion) -> None:
    """Warn, once, of a plugin whose summary fails.

    Args:
        hook_impl: The function of the plugin, as pluggy has it.
        error: Its exception.
        conversion: The conversion that was to be summarised.
    """
    message = (
        f"plugin '{hook_impl.plugin_name}': urdf2mbs_summary failed: {describe_exception(error)}"
    )
    # a page and the command line may both ask for the summary
    if message not in [diagnostic.message for diagnostic in conversion.diagnostics]:
        plugin_file = getattr(hook_impl.plugin, "__file__", None)
        line = find_line(Path(plugin_file), error) if plugin_file else None
        conversion.diagnostics.append(
            Diagnostic("warning", "plugin-summary", message, file=plugin_file, line=line)
        )
