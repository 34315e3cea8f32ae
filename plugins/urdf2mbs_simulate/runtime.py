"""What ``urdf2mbs.runtime`` has: the names of MBsysPy."""

from urdf2mbs_simulate.data import MbsData, MbsSensor
from urdf2mbs_simulate.dirdyn import MbsDirdyn, MbsPart
from urdf2mbs_simulate.results import Results

__all__ = ["MbsData", "MbsDirdyn", "MbsPart", "MbsSensor", "Results"]
