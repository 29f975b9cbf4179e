"""Injected faults: a run makes chosen devices fail at chosen times, in the same way on every backend."""

from robotcore.runtime.faults.base import Fault, FaultContext, PollingLayer
from robotcore.runtime.faults.planning import PlannedFault, plan_faults
from robotcore.runtime.faults.spec import Spec
from robotcore.runtime.faults.targets import ConnectionTarget, LoopTarget

__all__ = [
    "ConnectionTarget",
    "Fault",
    "FaultContext",
    "LoopTarget",
    "PlannedFault",
    "PollingLayer",
    "Spec",
    "plan_faults",
]
