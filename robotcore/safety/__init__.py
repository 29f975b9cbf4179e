"""The safety stage: what stands between every command and the motors, the same on every backend."""

from robotcore.safety.brakes import Brakes
from robotcore.safety.deadman import Deadman
from robotcore.safety.emergency import EmergencyStop
from robotcore.safety.following import WheelsFollow
from robotcore.safety.intervention import REST, Intervention
from robotcore.safety.latch import Latch
from robotcore.safety.rules import AccelerationLimit, DistanceAhead, RangeGuard, Rule, VelocityLimit, stopping_distance
from robotcore.safety.stage import LOST, Commit, SafetyStage, Stage
from robotcore.safety.unchanging import RangesChange
from robotcore.safety.watchdog import Watchdog
from robotcore.safety.whereabouts import Stay, Whereabouts

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
