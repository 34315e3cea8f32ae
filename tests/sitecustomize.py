"""Python imports this at its start where ``tests`` is on PYTHONPATH: plugins are hidden, too."""

import without  # noqa: F401
