"""The safety stage: what stands between every command and the motors, the same on every backend."""

from robotcore.safety.command_filter import LOST, Commit, SafetyStage, Stage
from robotcore.safety.deadman import Deadman
from robotcore.safety.latch import EmergencyStop, Latch
from robotcore.safety.motor_stop import Brakes
from robotcore.safety.plausibility import RangesChange, WheelsFollow
from robotcore.safety.rules import (
    REST,
    AccelerationLimit,
    DistanceAhead,
    Intervention,
    RangeGuard,
    Rule,
    VelocityLimit,
    stopping_distance,
)
from robotcore.safety.watchdog import Stay, Watchdog, Whereabouts

__all__ = [
    "LOST",
    "REST",
    "AccelerationLimit",
    "Brakes",
    "Commit",
    "Deadman",
    "DistanceAhead",
    "EmergencyStop",
    "Intervention",
    "Latch",
    "RangeGuard",
    "RangesChange",
    "Rule",
    "SafetyStage",
    "Stage",
    "Stay",
    "VelocityLimit",
    "Watchdog",
    "WheelsFollow",
    "Whereabouts",
    "stopping_distance",
]
