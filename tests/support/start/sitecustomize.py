"""Python imports this at its start where this folder is on PYTHONPATH: it hides plugins, too."""

import support.without  # noqa: F401
