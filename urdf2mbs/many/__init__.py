"""Many robots: several configs, a folder of robots, or a sweep, on all cores or on a cluster."""

from urdf2mbs.many.convert import Outcome, convert_many

__all__ = ["Outcome", "convert_many"]
