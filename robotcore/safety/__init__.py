"""The safety stage: what stands between every command and the motors, the same on every backend."""

from robotcore.safety.deadman import Deadman
from robotcore.safety.rules import AccelerationLimit, RangeGuard, Rule, VelocityLimit, stopping_distance
from robotcore.safety.stage import Commit, Intervention, SafetyStage

__all__ = [
    "AccelerationLimit",
    "Commit",
    "Deadman",
    "Intervention",
    "RangeGuard",
    "Rule",
    "SafetyStage",
    "VelocityLimit",
    "stopping_distance",
]
