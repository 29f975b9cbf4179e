"""The faults of a run: every spec understood, every one fitting the robot, before anything is opened."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from pydantic import ValidationError

from robotcore.description import RobotDescription, first_mistake
from robotcore.errors import UsageError, suggestion
from robotcore.hal.clock import Clock
from robotcore.runtime.faults.catalogue import effects_on, faults_called
from robotcore.runtime.faults.fault import Fault, Kind
from robotcore.runtime.faults.form import VALUE, form_of
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.faults.selected import Selected
from robotcore.runtime.faults.spec import Spec, shown
from robotcore.runtime.faults.targets import ROLES, Target, find_target
from robotcore.runtime.layers.layer import Layer


@dataclass(frozen=True)
class PlannedFault:
    """A fault on devices of the robot; ``position`` is its place among the faults of the run."""

    spec: Spec
    fault: Fault
    target: Target
    position: int

    def __str__(self) -> str:
        """As it is written, in its canonical form."""
        return str(self.spec)

    def layer(self, clock: Clock, seed: int) -> Layer:
        """Return the layer over the target's devices, for one run."""
        occasion = Occasion(clock, seed, self.position, str(self))
        return Selected(self.fault.layer(occasion), self.target.devices)

    def is_on(self, time: float) -> bool:
        """Return whether the fault is there at a time on the robot's clock."""
        return self.fault.is_on(time)


def plan_faults(
    specs: Sequence[str], description: RobotDescription, opened: Collection[str]
) -> tuple[PlannedFault, ...]:
    """Return the faults of a run in which the devices of these names are open.

    Raises UsageError in one or two lines, with the right form, where a spec is wrong.
    """
    return tuple(_planned(Spec.parse(text), description, opened, index) for index, text in enumerate(specs))


def _planned(spec: Spec, description: RobotDescription, opened: Collection[str], position: int) -> PlannedFault:
    try:
        candidates = faults_called(spec.effect)
        target = find_target(spec.target, description, opened)
    except UsageError as error:
        raise _refused(spec, f"{error}\nrobotcore faults lists what there is") from error
    fault = next((fault for fault in candidates if target.kind in fault.on), None)
    if fault is None:
        raise _misplaced(spec, target.kind, candidates)
    return PlannedFault(spec, _checked(spec, fault), target, position)


def _misplaced(spec: Spec, kind: Kind, candidates: Sequence[type[Fault]]) -> UsageError:
    fitting = [role for each, role in ROLES.items() if any(each in fault.on for fault in candidates)]
    return _refused(
        spec,
        f"{spec.effect} is for {' or '.join(fitting)}; on a {kind.value} there are: {', '.join(effects_on(kind))}\n"
        f'Write it like "{candidates[0].example}"; robotcore faults lists what there is',
    )


def _checked(spec: Spec, fault: type[Fault]) -> Fault:
    """Return the fault with its parameters; UsageError says which one does not fit, and the right form."""
    misfit = _misfit(spec, fault)
    if not misfit:
        try:
            return fault.model_validate({**dict(spec.parameters), **({VALUE: spec.value} if spec.value else {})})
        except ValidationError as error:
            key, reason = first_mistake(error)
            misfit = f"{spec.effect if key == VALUE else key} {reason}".strip()
    raise _refused(spec, f'{misfit}\nWrite it as "{form_of(spec.target, spec.effect, fault)}"')


def _misfit(spec: Spec, fault: type[Fault]) -> str:
    """Return what there is that should not be, or what is not that should; nothing where all is there."""
    known = [name for name in fault.model_fields if name != VALUE]
    for key, _ in spec.parameters:
        if key not in known:
            return f"unknown parameter {key!r}. {suggestion(key, known)}"
    if spec.value is None:
        return f"{spec.effect} needs a value" if _needs_value(fault) else ""
    return "" if VALUE in fault.model_fields else f"{spec.effect} takes no value"


def _needs_value(fault: type[Fault]) -> bool:
    return VALUE in fault.model_fields and fault.model_fields[VALUE].is_required()


def _refused(spec: Spec, reason: str) -> UsageError:
    return UsageError(f"--fault {shown(str(spec))}: {reason}")
