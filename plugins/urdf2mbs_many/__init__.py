"""Many robots: several configs, a folder of robots, or a sweep, on all cores or on a cluster."""

from urdf2mbs_many.convert import convert_many
from urdf2mbs_many.job import Outcome

__all__ = ["Outcome", "convert_many"]
