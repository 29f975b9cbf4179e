"""The safety functions of a run, equal on every backend: command filter, rules, deadman, latch and watchdog."""

from robotcore.safety.command_filter import LOST, CommandFilter, SafetyFilter, TickCommands
from robotcore.safety.deadman import Deadman
from robotcore.safety.latch import EmergencyStop, Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.range_guard import DistanceAhead, RangeGuard, compute_stopping_distance
from robotcore.safety.sensor_checks import StuckRangeCheck, WheelTrackingCheck
from robotcore.safety.velocity_limits import STOPPED, AccelerationLimit, Intervention, Rule, VelocityLimit
from robotcore.safety.watchdog import ActivityMonitor, TimeLimit, Watchdog

__all__ = [
    "LOST",
    "STOPPED",
    "AccelerationLimit",
    "ActivityMonitor",
    "CommandFilter",
    "Deadman",
    "DistanceAhead",
    "EmergencyStop",
    "Intervention",
    "Latch",
    "RangeGuard",
    "Rule",
    "SafetyFilter",
    "StopGroup",
    "StuckRangeCheck",
    "TickCommands",
    "TimeLimit",
    "VelocityLimit",
    "Watchdog",
    "WheelTrackingCheck",
    "compute_stopping_distance",
]
