"""Faults on purpose: what can fail on a robot, made to fail when and as one says, the same on every backend."""

from robotcore.runtime.faults.eager import EagerLayer
from robotcore.runtime.faults.fault import SENSORS, Fault, Kind
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.faults.planned import PlannedFault, plan_faults
from robotcore.runtime.faults.spec import Spec

__all__ = ["SENSORS", "EagerLayer", "Fault", "Kind", "Occasion", "PlannedFault", "Spec", "plan_faults"]
