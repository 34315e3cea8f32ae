from urdf2mbs_many.convert import convert_many as convert_many
from urdf2mbs_many.job import Outcome as Outcome
from urdf2mbs_simulate.project import simulate as simulate
from urdf2mbs_simulate.push import Push as Push
from urdf2mbs_simulate.results import Results as Results
from urdf2mbs_simulate.robot import Robot as Robot
from urdf2mbs_simulate.robot import load_equations as load_equations

from urdf2mbs.api import Result as Result
from urdf2mbs.api import Verdict as Verdict
from urdf2mbs.api import convert as convert
from urdf2mbs.api import verify as verify
from urdf2mbs.engine.config import Config as Config
from urdf2mbs.messages.diagnostics import ConfigError as ConfigError
from urdf2mbs.messages.diagnostics import ConversionError as ConversionError
from urdf2mbs.messages.diagnostics import Diagnostic as Diagnostic
