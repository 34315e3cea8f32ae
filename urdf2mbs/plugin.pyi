from urdf2mbs import spatial as spatial
from urdf2mbs.conversion import Conversion as Conversion
from urdf2mbs.conversion import File as File
from urdf2mbs.conversion import Names as Names
from urdf2mbs.conversion import Segment as Segment
from urdf2mbs.conversion import Settings as Settings
from urdf2mbs.conversion import Step as Step
from urdf2mbs.conversion import Summary as Summary
from urdf2mbs.conversion import Use as Use
from urdf2mbs.conversion import choose as choose
from urdf2mbs.conversion import fits as fits
from urdf2mbs.hookspecs import Command as Command
from urdf2mbs.hookspecs import Pass as Pass
from urdf2mbs.hookspecs import PassEntry as PassEntry
from urdf2mbs.hookspecs import always as always
from urdf2mbs.hookspecs import asked as asked
from urdf2mbs.hookspecs import hookimpl as hookimpl
from urdf2mbs.hookspecs import in_project as in_project
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs.model import LinkFrame as LinkFrame
from urdf2mbs.messages.diagnostics import ConfigError as ConfigError
from urdf2mbs.messages.diagnostics import ConversionError as ConversionError
from urdf2mbs.messages.diagnostics import Diagnostic as Diagnostic
from urdf2mbs.messages.diagnostics import nearest as nearest
from urdf2mbs.proof.verdict import Difference as Difference
from urdf2mbs.states import Estimates as Estimates
from urdf2mbs.states import JointModels as JointModels
from urdf2mbs.states import OnPurpose as OnPurpose
from urdf2mbs.states import Placed as Placed
from urdf2mbs.urdf import model as urdf
from urdf2mbs.urdf.mimic import follow as follow

VERSION: int
__all__ = ["mbs", "urdf"]
