"""The contract between controllers and the harness."""

from .cache import cache_folder
from .conformance import Finding, check_controller
from .controller import Controller, DesignInertia, build_controller, check_inertia, hook, knowledge_levels
from .errors import InvalidInput, PlugInFailure, Refusal, TorquebenchError, UnknownName
from .knowledge import STANDARD_LEVELS, KnowledgeProvider, NoKnowledge, Oracle, PayloadTruth
from .ledger import LedgerEntry
from .observation import Observation
from .robot_model import RigidBodyState, RobotModel
from .target import Preview, Reference, Target
from .task import Actuation, Task

__all__ = [
    "STANDARD_LEVELS",
    "Actuation",
    "Controller",
    "DesignInertia",
    "Finding",
    "InvalidInput",
    "KnowledgeProvider",
    "LedgerEntry",
    "NoKnowledge",
    "Observation",
    "Oracle",
    "PayloadTruth",
    "PlugInFailure",
    "Preview",
    "Reference",
    "Refusal",
    "RigidBodyState",
    "RobotModel",
    "Target",
    "Task",
    "TorquebenchError",
    "UnknownName",
    "build_controller",
    "cache_folder",
    "check_controller",
    "check_inertia",
    "hook",
    "knowledge_levels",
]
