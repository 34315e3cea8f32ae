"""The runtime for Robotran projects: the ``main.py`` of a project imports it by this name."""

import sys

from urdf2mbs.engine.plugins import load_plugins

sys.modules[__name__] = load_plugins().load_name("runtime")
