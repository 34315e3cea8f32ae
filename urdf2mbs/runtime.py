"""The runtime for Robotran projects: the ``main.py`` of a project imports it by this name."""

import sys

from urdf2mbs.engine.plugins import of_ours

sys.modules[__name__] = of_ours("runtime")
