"""Which tests may be skipped where all that they need is installed."""

import re
from collections.abc import Iterable

from support.folders import SHARED

#: Reasons that hold on a complete machine: what no package index has, what only another system
#: has, what the input itself rules out.
EXPECTED = [
    "MBsysPy",
    "pdflatex",
    "(jax|strace|cmake) is not",
    "a single massless link",
    "nothing moves",
    "an infinite angle has no sine",
    "init proposes this very output",
]
if not SHARED.is_dir():
    EXPECTED += [
        "empty parameter set",
        "shared",
        "beside the",
        "(files|samples) are not there",
        "are not here",
    ]


def find_unexpected(reports: Iterable[object]) -> list[str]:
    """Return why tests were skipped, each reason once, but for those that are expected.

    Args:
        reports: pytest's reports of skipped tests.
    """
    reasons = {str(report.longrepr[-1]) for report in reports}  # type: ignore[attr-defined]
    return sorted(
        reason for reason in reasons if not any(re.search(each, reason) for each in EXPECTED)
    )
