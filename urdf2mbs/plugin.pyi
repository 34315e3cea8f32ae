from urdf2mbs import spatial as spatial
from urdf2mbs.commands import parser as parser
from urdf2mbs.commands.kinds import check_ending as check_ending
from urdf2mbs.commands.kinds import check_kind as check_kind
from urdf2mbs.commands.kinds import find_kind as find_kind
from urdf2mbs.commands.kinds import find_model as find_model
from urdf2mbs.commands.kinds import propose_in_folder as propose_in_folder
from urdf2mbs.commands.printing import beside as beside
from urdf2mbs.commands.printing import near as near
from urdf2mbs.commands.printing import print_diagnostics as tell_diagnostics
from urdf2mbs.commands.printing import print_json as print_json
from urdf2mbs.commands.printing import print_summary as tell
from urdf2mbs.commands.printing import with_near_paths as with_near_paths
from urdf2mbs.commands.progress import Progress as Progress
from urdf2mbs.commands.progress import estimate_end as estimate_end
from urdf2mbs.commands.settings import ALONE as ALONE
from urdf2mbs.commands.settings import FLAGS as FLAGS
from urdf2mbs.commands.settings import READING as READING
from urdf2mbs.commands.settings import add_fields as add_fields
from urdf2mbs.commands.settings import add_json as add_json
from urdf2mbs.commands.settings import add_no_plugins as add_no_plugins
from urdf2mbs.commands.settings import add_printing as add_printing
from urdf2mbs.commands.settings import add_running as add_running
from urdf2mbs.commands.settings import add_verbose as add_verbose
from urdf2mbs.commands.settings import choose_fields as choose_fields
from urdf2mbs.commands.settings import field_docs as field_docs
from urdf2mbs.commands.settings import path as path
from urdf2mbs.commands.settings import refuse as refuse
from urdf2mbs.commands.settings import robot_or_config as robot_or_config
from urdf2mbs.commands.settings import without_config as without_config
from urdf2mbs.commands.streams import STREAM as STREAM
from urdf2mbs.commands.streams import is_stream as is_stream
from urdf2mbs.commands.streams import saving as saving
from urdf2mbs.config.lines import Key as Key
from urdf2mbs.config.lines import Lines as Lines
from urdf2mbs.config.lines import dotted as dotted
from urdf2mbs.config.load import config_of as config_of
from urdf2mbs.config.load import typed as typed
from urdf2mbs.config.model import Config as Config
from urdf2mbs.config.model import Project as Project
from urdf2mbs.config.model import Range as Range
from urdf2mbs.config.model import Sweep as Sweep
from urdf2mbs.config.paths import expand as expand
from urdf2mbs.conversion import Conversion as Conversion
from urdf2mbs.conversion import File as File
from urdf2mbs.conversion import Intent as Intent
from urdf2mbs.conversion import Names as Names
from urdf2mbs.conversion import Segment as Segment
from urdf2mbs.conversion import Settings as Settings
from urdf2mbs.conversion import Step as Step
from urdf2mbs.conversion import Summary as Summary
from urdf2mbs.conversion import Use as Use
from urdf2mbs.conversion import choose as choose
from urdf2mbs.conversion import fits as fits
from urdf2mbs.disk import files as files
from urdf2mbs.disk.files import absolute as absolute
from urdf2mbs.disk.files import is_file as is_file
from urdf2mbs.disk.files import is_folder as is_folder
from urdf2mbs.disk.files import is_portable as is_portable
from urdf2mbs.disk.files import model_of as model_of
from urdf2mbs.disk.files import noting as noting
from urdf2mbs.disk.files import project_of as project_of
from urdf2mbs.disk.files import read_bytes as read_bytes
from urdf2mbs.disk.files import read_model as read_model
from urdf2mbs.disk.files import size as size
from urdf2mbs.disk.files import temporary_name as temporary_name
from urdf2mbs.disk.record import RECORD as RECORD
from urdf2mbs.disk.record import checksum as checksum
from urdf2mbs.disk.record import is_ours as is_ours
from urdf2mbs.disk.record import was_ours as was_ours
from urdf2mbs.disk.xml import safe_parser as safe_parser
from urdf2mbs.engine.entry_points import version_of as version_of
from urdf2mbs.engine.order import ConfiguredPass as ConfiguredPass
from urdf2mbs.engine.order import list_method as list_method
from urdf2mbs.engine.output import check_ours as check_ours
from urdf2mbs.engine.output import write as write_output
from urdf2mbs.engine.output import write_files as write_files
from urdf2mbs.engine.pipeline import Pipeline as Pipeline
from urdf2mbs.engine.plugins import Plugins as Plugins
from urdf2mbs.engine.plugins import load_pass as load_pass
from urdf2mbs.engine.summaries import of_plugins as of_plugins
from urdf2mbs.hookspecs import GROUP as GROUP
from urdf2mbs.hookspecs import Command as Command
from urdf2mbs.hookspecs import Pass as Pass
from urdf2mbs.hookspecs import PassEntry as PassEntry
from urdf2mbs.hookspecs import always as always
from urdf2mbs.hookspecs import asked as asked
from urdf2mbs.hookspecs import hookimpl as hookimpl
from urdf2mbs.hookspecs import in_project as in_project
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs import writer as writer
from urdf2mbs.mbs.fields import INSIDE as INSIDE
from urdf2mbs.mbs.fields import KEPT as KEPT
from urdf2mbs.mbs.fields import OBJECTS as OBJECTS
from urdf2mbs.mbs.fields import Table as Table
from urdf2mbs.mbs.kinematics import PlacedJoint as PlacedJoint
from urdf2mbs.mbs.kinematics import Placement as Placement
from urdf2mbs.mbs.kinematics import compute_placement as compute_placement
from urdf2mbs.mbs.model import BASE as BASE
from urdf2mbs.mbs.model import CUTS as CUTS
from urdf2mbs.mbs.model import ORIGIN as ORIGIN
from urdf2mbs.mbs.model import RGB as RGB
from urdf2mbs.mbs.model import SENSOR_MEASURES as SENSOR_MEASURES
from urdf2mbs.mbs.model import XY as XY
from urdf2mbs.mbs.model import Base as Base
from urdf2mbs.mbs.model import Body as Body
from urdf2mbs.mbs.model import Connection as Connection
from urdf2mbs.mbs.model import Drawing as Drawing
from urdf2mbs.mbs.model import Joint as MbsJoint
from urdf2mbs.mbs.model import LinkFrame as LinkFrame
from urdf2mbs.mbs.model import Mbs as Mbs
from urdf2mbs.mbs.model import Parameter as Parameter
from urdf2mbs.mbs.model import Part as Part
from urdf2mbs.mbs.model import Point as Point
from urdf2mbs.mbs.model import Sensor as MbsSensor
from urdf2mbs.mbs.model import Shape as Shape
from urdf2mbs.mbs.model import UserConstraint as UserConstraint
from urdf2mbs.mbs.model import UserModel as UserModel
from urdf2mbs.mbs.model import without_origin as without_origin
from urdf2mbs.mbs.names import free_name as free_name
from urdf2mbs.mbs.names import identifiers as identifiers
from urdf2mbs.mbs.reader import read_mbs as read_mbs
from urdf2mbs.mbs.reader import read_mbs_again as read_mbs_again
from urdf2mbs.mbs.reader import read_mbs_file as read_mbs_file
from urdf2mbs.messages.diagnostics import ConfigError as ConfigError
from urdf2mbs.messages.diagnostics import ConversionError as ConversionError
from urdf2mbs.messages.diagnostics import Diagnostic as Diagnostic
from urdf2mbs.messages.diagnostics import counted as counted
from urdf2mbs.messages.diagnostics import nearest as nearest
from urdf2mbs.messages.diagnostics import not_installed as not_installed
from urdf2mbs.messages.diagnostics import printable as printable
from urdf2mbs.messages.diagnostics import quoted as quoted
from urdf2mbs.messages.diagnostics import some as some
from urdf2mbs.proof.urdf_side import in_plane as in_plane
from urdf2mbs.proof.verdict import Difference as Difference
from urdf2mbs.ranges import PositiveLength as PositiveLength
from urdf2mbs.ranges import Tolerance as Tolerance
from urdf2mbs.ranges import rounded as rounded
from urdf2mbs.spatial import HERE as HERE
from urdf2mbs.spatial import IDENTITY as IDENTITY
from urdf2mbs.spatial import NO_INERTIA as NO_INERTIA
from urdf2mbs.spatial import ROUNDING as ROUNDING
from urdf2mbs.spatial import ZERO as ZERO
from urdf2mbs.spatial import Pose as Pose
from urdf2mbs.spatial import Rot as Rot
from urdf2mbs.spatial import Sym as Sym
from urdf2mbs.spatial import Vec as Vec
from urdf2mbs.spatial import add as add
from urdf2mbs.spatial import axis_turns as axis_turns
from urdf2mbs.spatial import compose as compose
from urdf2mbs.spatial import cross as cross
from urdf2mbs.spatial import direction as direction
from urdf2mbs.spatial import dot as dot
from urdf2mbs.spatial import drop_rounding as drop_rounding
from urdf2mbs.spatial import fewest_turns as fewest_turns
from urdf2mbs.spatial import from_rpy as from_rpy
from urdf2mbs.spatial import from_turns as from_turns
from urdf2mbs.spatial import inverse as inverse
from urdf2mbs.spatial import lump as lump
from urdf2mbs.spatial import multiply as multiply
from urdf2mbs.spatial import rotate as rotate
from urdf2mbs.spatial import rotate_inertia as rotate_inertia
from urdf2mbs.spatial import transpose as transpose
from urdf2mbs.spatial import unit as unit
from urdf2mbs.states import Estimates as Estimates
from urdf2mbs.states import JointModels as JointModels
from urdf2mbs.states import OnPurpose as OnPurpose
from urdf2mbs.states import Placed as Placed
from urdf2mbs.states import SecondOpinions as SecondOpinions
from urdf2mbs.summary import Report as Report
from urdf2mbs.summary import left_out as left_out
from urdf2mbs.summary import report as report
from urdf2mbs.summary import verdict as verdict
from urdf2mbs.urdf import inertia as inertia
from urdf2mbs.urdf import model as urdf
from urdf2mbs.urdf import packages as packages
from urdf2mbs.urdf import written as written
from urdf2mbs.urdf import xml as xml
from urdf2mbs.urdf.elements import LEGACY as LEGACY
from urdf2mbs.urdf.elements import LEGACY_HINT as LEGACY_HINT
from urdf2mbs.urdf.elements import is_xacro as is_xacro
from urdf2mbs.urdf.elements import plain as plain
from urdf2mbs.urdf.elements import quote as quote
from urdf2mbs.urdf.elements import split_tag as split_tag
from urdf2mbs.urdf.harmless import OFF as OFF
from urdf2mbs.urdf.harmless import ON as ON
from urdf2mbs.urdf.inertia import moments as moments
from urdf2mbs.urdf.inertia import principal as principal
from urdf2mbs.urdf.inertia import second_moment as second_moment
from urdf2mbs.urdf.macros import is_robot_file as is_robot_file
from urdf2mbs.urdf.mimic import find_locked_joints as find_locked_joints
from urdf2mbs.urdf.mimic import follow as follow
from urdf2mbs.urdf.model import JOINT_TYPES as JOINT_TYPES
from urdf2mbs.urdf.model import Box as Box
from urdf2mbs.urdf.model import Capsule as Capsule
from urdf2mbs.urdf.model import ClosingJoint as ClosingJoint
from urdf2mbs.urdf.model import Collision as Collision
from urdf2mbs.urdf.model import Cylinder as Cylinder
from urdf2mbs.urdf.model import Dynamics as Dynamics
from urdf2mbs.urdf.model import Extension as Extension
from urdf2mbs.urdf.model import Geometry as Geometry
from urdf2mbs.urdf.model import Inertial as Inertial
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Link as Link
from urdf2mbs.urdf.model import Mesh as Mesh
from urdf2mbs.urdf.model import Mimic as Mimic
from urdf2mbs.urdf.model import Origin as Origin
from urdf2mbs.urdf.model import Robot as Robot
from urdf2mbs.urdf.model import Sensor as UrdfSensor
from urdf2mbs.urdf.model import Sphere as Sphere
from urdf2mbs.urdf.model import Visual as Visual
from urdf2mbs.urdf.packages import Packages as Packages
from urdf2mbs.urdf.packages import absolute_path as absolute_path
from urdf2mbs.urdf.packages import walk as walk
from urdf2mbs.urdf.packages import workspace as workspace
from urdf2mbs.urdf.reader import Expansion as Expansion
from urdf2mbs.urdf.reader import Located as Located
from urdf2mbs.urdf.reader import choose_file_name as choose_file_name
from urdf2mbs.urdf.reader import choose_title as choose_title
from urdf2mbs.urdf.reader import is_name as is_name
from urdf2mbs.urdf.reader import read_robot_file as read_robot_file
from urdf2mbs.urdf.reader import read_text as read_text
from urdf2mbs.urdf.reader import stem as stem
from urdf2mbs.urdf.renaming import rename_elements as rename_elements
from urdf2mbs.urdf.values import Reading as Reading

VERSION: int
__all__ = [
    "ALONE",
    "BASE",
    "CUTS",
    "FLAGS",
    "GROUP",
    "HERE",
    "IDENTITY",
    "INSIDE",
    "JOINT_TYPES",
    "KEPT",
    "LEGACY",
    "LEGACY_HINT",
    "NO_INERTIA",
    "OBJECTS",
    "OFF",
    "ON",
    "ORIGIN",
    "READING",
    "RECORD",
    "RGB",
    "ROUNDING",
    "SENSOR_MEASURES",
    "STREAM",
    "VERSION",
    "XY",
    "ZERO",
    "Base",
    "Body",
    "Box",
    "Capsule",
    "ClosingJoint",
    "Collision",
    "Command",
    "Config",
    "ConfigError",
    "ConfiguredPass",
    "Connection",
    "Conversion",
    "ConversionError",
    "Cylinder",
    "Diagnostic",
    "Difference",
    "Drawing",
    "Dynamics",
    "Estimates",
    "Expansion",
    "Extension",
    "File",
    "Geometry",
    "Inertial",
    "Intent",
    "JointModels",
    "Key",
    "Lines",
    "Link",
    "LinkFrame",
    "Located",
    "Mbs",
    "MbsJoint",
    "MbsSensor",
    "Mesh",
    "Mimic",
    "Names",
    "OnPurpose",
    "Origin",
    "Packages",
    "Parameter",
    "Part",
    "Pass",
    "PassEntry",
    "Pipeline",
    "Placed",
    "PlacedJoint",
    "Placement",
    "Plugins",
    "Point",
    "Pose",
    "PositiveLength",
    "Progress",
    "Project",
    "Range",
    "Reading",
    "Report",
    "Robot",
    "Rot",
    "SecondOpinions",
    "Segment",
    "Settings",
    "Shape",
    "Sphere",
    "Step",
    "Summary",
    "Sweep",
    "Sym",
    "Table",
    "Tolerance",
    "UrdfJoint",
    "UrdfSensor",
    "Use",
    "UserConstraint",
    "UserModel",
    "Vec",
    "Visual",
    "absolute",
    "absolute_path",
    "add",
    "add_fields",
    "add_json",
    "add_no_plugins",
    "add_printing",
    "add_running",
    "add_verbose",
    "always",
    "asked",
    "axis_turns",
    "beside",
    "check_ending",
    "check_kind",
    "check_ours",
    "checksum",
    "choose",
    "choose_fields",
    "choose_file_name",
    "choose_title",
    "compose",
    "compute_placement",
    "config_of",
    "counted",
    "cross",
    "direction",
    "dot",
    "dotted",
    "drop_rounding",
    "estimate_end",
    "expand",
    "fewest_turns",
    "field_docs",
    "files",
    "find_kind",
    "find_locked_joints",
    "find_model",
    "fits",
    "follow",
    "free_name",
    "from_rpy",
    "from_turns",
    "hookimpl",
    "identifiers",
    "in_plane",
    "in_project",
    "inertia",
    "inverse",
    "is_file",
    "is_folder",
    "is_name",
    "is_ours",
    "is_portable",
    "is_robot_file",
    "is_stream",
    "is_xacro",
    "left_out",
    "list_method",
    "load_pass",
    "lump",
    "mbs",
    "model_of",
    "moments",
    "multiply",
    "near",
    "nearest",
    "not_installed",
    "noting",
    "of_plugins",
    "packages",
    "parser",
    "path",
    "plain",
    "principal",
    "print_json",
    "printable",
    "project_of",
    "propose_in_folder",
    "quote",
    "quoted",
    "read_bytes",
    "read_mbs",
    "read_mbs_again",
    "read_mbs_file",
    "read_model",
    "read_robot_file",
    "read_text",
    "refuse",
    "rename_elements",
    "report",
    "robot_or_config",
    "rotate",
    "rotate_inertia",
    "rounded",
    "safe_parser",
    "saving",
    "second_moment",
    "size",
    "some",
    "spatial",
    "split_tag",
    "stem",
    "tell",
    "tell_diagnostics",
    "temporary_name",
    "transpose",
    "typed",
    "unit",
    "urdf",
    "verdict",
    "version_of",
    "walk",
    "was_ours",
    "with_near_paths",
    "without_config",
    "without_origin",
    "workspace",
    "write_files",
    "write_output",
    "writer",
    "written",
    "xml",
]
