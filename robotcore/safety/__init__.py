"""The safety stage: what stands between every command and the motors, the same on every backend."""

from robotcore.safety.deadman import Deadman
from robotcore.safety.latch import Latch
from robotcore.safety.rules import AccelerationLimit, DistanceAhead, RangeGuard, Rule, VelocityLimit, stopping_distance
from robotcore.safety.stage import Commit, Intervention, SafetyStage, Stage

__all__ = [
    "AccelerationLimit",
    "Commit",
    "Deadman",
    "DistanceAhead",
    "Intervention",
    "Latch",
    "RangeGuard",
    "Rule",
    "SafetyStage",
    "Stage",
    "VelocityLimit",
    "stopping_distance",
]
