"""The runtime for Robotran projects: the ``main.py`` of a project imports it by this name."""

import sys

from urdf2mbs.engine.plugins import plugins_of

sys.modules[__name__] = plugins_of((), installed=False).find("runtime")
