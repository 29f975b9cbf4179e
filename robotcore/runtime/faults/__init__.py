"""Injected faults: a run makes chosen devices fail at chosen times, in the same way on every backend."""

from robotcore.runtime.faults.base import SENSORS, Fault, FaultContext, PollingLayer, TargetKind
from robotcore.runtime.faults.planning import PlannedFault, plan_faults
from robotcore.runtime.faults.spec import Spec

__all__ = ["SENSORS", "Fault", "FaultContext", "PlannedFault", "PollingLayer", "Spec", "TargetKind", "plan_faults"]
