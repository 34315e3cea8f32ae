"""A runtime for Robotran projects, with the names of Robotran's own, MBsysPy.

``workR/main.py`` and user functions use it as they use MBsysPy.  See ``docs/simulate.md``.
"""

from urdf2mbs_simulate.data import MbsData, MbsSensor
from urdf2mbs_simulate.dirdyn import MbsDirdyn, MbsPart
from urdf2mbs_simulate.results import Results

__all__ = ["MbsData", "MbsDirdyn", "MbsPart", "MbsSensor", "Results"]
