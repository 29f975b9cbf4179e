"""Faults on purpose: what can fail on a robot, made to fail when and as one says, the same on every backend."""

from robotcore.faults.eager import EagerLayer
from robotcore.faults.fault import SENSORS, Fault, Kind
from robotcore.faults.occasion import Occasion
from robotcore.faults.planned import PlannedFault, plan_faults
from robotcore.faults.spec import Spec

__all__ = ["SENSORS", "EagerLayer", "Fault", "Kind", "Occasion", "PlannedFault", "Spec", "plan_faults"]
