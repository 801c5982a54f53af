"""Training of the cerebellum's patterns, one for each load; needs torch only while it trains."""

from .evaluation import GravityError, answers, gravity_heldout, gravity_torques
from .pipeline import Lesson, evaluation_groups, train_cerebellum
from .recipes import PRESETS, Recipe
from .sets import SETS, TrainingSet, Workspace, training_set

__all__ = [
    "PRESETS",
    "SETS",
    "GravityError",
    "Lesson",
    "Recipe",
    "TrainingSet",
    "Workspace",
    "answers",
    "evaluation_groups",
    "gravity_heldout",
    "gravity_torques",
    "train_cerebellum",
    "training_set",
]
