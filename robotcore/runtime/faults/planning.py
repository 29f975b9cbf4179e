"""Plans the faults of a run: finds the effect and the target of each specification before the robot is opened."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from pydantic import ValidationError

from robotcore.description import RobotDescription, first_mistake
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.clock import Clock
from robotcore.plugins import FAULTS, fault_names, load_registered
from robotcore.runtime.faults.base import Fault, FaultContext
from robotcore.runtime.faults.checked_layer import CheckedLayer, FaultCode
from robotcore.runtime.faults.spec import VALUE, Spec, forms_of, quote_text
from robotcore.runtime.faults.targets import FaultTarget, TargetClass, find_target, list_classes, name_target
from robotcore.runtime.layers.base import Layer


def read_effect(name: str) -> str:
    """Return the effect of a registered fault: the part of its name before the dot, such as ``noise``.

    The part after the dot distinguishes faults with the same effect, as in ``noise.camera`` and ``noise.range``.
    """
    return name.partition(".")[0]


def load_fault(name: str) -> type[Fault]:
    """Return the fault class with a registered name.

    Raises BackendMissingError if the class cannot be loaded or does not inherit Fault.
    """
    found = load_registered("fault", FAULTS, name)
    if not (isinstance(found, type) and issubclass(found, Fault)):
        raise BackendMissingError(
            f"the entry point of the fault {name!r} is not a subclass of robotcore.runtime.faults.Fault. Correct it"
        )
    if not isinstance(found.target_classes, tuple):
        raise BackendMissingError(
            f"`target_classes` of the fault {name!r} is {found.target_classes!r}. Write a tuple of classes of devices"
        )
    return found


def find_faults(effect: str) -> list[type[Fault]]:
    """Return the fault classes with an effect. They are for different classes of targets.

    Raises UnknownNameError if no fault has the effect. Raises UsageError if no fault is registered.
    """
    names = [name for name in fault_names() if read_effect(name) == effect]
    if not names and (known := {read_effect(name) for name in fault_names()}):
        raise UnknownNameError("effect", effect, sorted(known))
    return [load_fault(name) for name in names or [effect]]


def select_fault(faults: Iterable[type[Fault]], target: TargetClass) -> type[Fault] | None:
    """Return the fault for a class of targets from the faults with one effect; None if none of them fits.

    If several fit, this is the one for the smallest class: a fault for range sensors comes before one for all sensors.
    """
    fitting = [fault for fault in faults if fault.fits(target)]
    return min(
        fitting, key=lambda fault: sum(issubclass(each, fault.target_classes) for each in target.__mro__), default=None
    )


def targets_for(name: str) -> list[str]:
    """Return the names of the targets on which the effect of a registered fault is this fault."""
    fault = load_fault(name)
    candidates = [each for other, each in _loadable_faults() if read_effect(other) == read_effect(name)]
    return [name_target(each.kind) for each in list_classes() if select_fault(candidates, each) is fault]


def effects_on(target: TargetClass) -> list[str]:
    """Return the names of the effects on a class of targets."""
    return sorted({read_effect(name) for name, fault in _loadable_faults() if fault.fits(target)})


def _loadable_faults() -> Iterator[tuple[str, type[Fault]]]:
    for name in fault_names():
        with suppress(BackendMissingError):
            yield name, load_fault(name)


def list_modules(specs: Iterable[str]) -> list[str]:
    """Return the names of the modules that define the faults of these specifications.

    Invalid specifications are left out.
    """
    names = {word.partition("=")[0].replace("-", "_") for spec in specs for word in spec.split()[1:2]}
    return sorted(load_fault(name).__module__ for name in fault_names() if read_effect(name) in names)


@dataclass(frozen=True)
class PlannedFault:
    """A fault with a checked specification, and its target on the robot.

    >>> from robotcore.description import load_robot
    >>> from robotcore.runtime.faults import plan_faults
    >>> (fault,) = plan_faults(["left_motor weak=0.5 after=2"], load_robot("rover"), opened=["left_motor"])
    >>> str(fault), fault.is_active(1.0), fault.is_active(3.0)
    ('left_motor weak=0.5 after=2', False, True)
    """

    spec: Spec
    """The specification."""
    fault: Fault
    """The fault with its parameters."""
    target: FaultTarget
    """The target whose devices fail."""
    position: int
    """The index of the fault in the list of the run's faults, from 0."""

    def __str__(self) -> str:
        """Return the specification in its canonical form."""
        return str(self.spec)

    def layer(self, clock: Clock, seed: int) -> Layer:
        """Return the layer that makes the devices of the target fail in one run."""
        code = FaultCode(str(self))
        layer = code.get("", Layer, self.fault.layer, FaultContext(clock, seed, self.position, str(self)))
        return CheckedLayer(layer, code, self.target.devices)

    def is_active(self, time: float) -> bool:
        """Return whether the fault is active at ``time``, in seconds on the robot's clock."""
        return FaultCode(str(self)).call("", self.fault.is_active, time)


def plan_faults(
    specs: Sequence[str], description: RobotDescription, opened: Collection[str]
) -> tuple[PlannedFault, ...]:
    """Check the specifications of a run's faults, and return the faults.

    specs: the specifications, such as ``camera drop=0.2``.
    description: the robot.
    opened: the names of the devices that the run opens.

    Raises UsageError with the correct form if a specification is wrong.

    >>> from robotcore.description import load_robot
    >>> faults = plan_faults(["camera drop=0.2", "loop stall=0.5 after=3"], load_robot("rover"), opened=["eye"])
    >>> [str(fault) for fault in faults]
    ['camera drop=0.2', 'loop stall=0.5 after=3']
    """
    if isinstance(specs, str):
        raise UsageError(f"faults is the text {specs!r}. Write a list: faults=[{specs!r}]", kind="faults-not-a-list")
    return tuple(_plan_fault(Spec.parse(text), description, opened, index) for index, text in enumerate(specs))


def _plan_fault(spec: Spec, description: RobotDescription, opened: Collection[str], position: int) -> PlannedFault:
    try:
        candidates = find_faults(spec.effect)
        target = find_target(spec.target, description, opened)
    except UsageError as error:
        raise _build_error(spec, f"{error}\nrobotcore faults lists all effects", error.kind) from error
    fault = select_fault(candidates, target.kind)
    if fault is None:
        raise _build_kind_error(spec, target.kind, candidates)
    return PlannedFault(spec, _build_fault(spec, fault, target), target, position)


def _build_kind_error(spec: Spec, target: TargetClass, candidates: Sequence[type[Fault]]) -> UsageError:
    fitting = [name_target(each.kind) for each in list_classes() if select_fault(candidates, each)]
    return _build_error(
        spec,
        f"{spec.effect} is for {' or '.join(fitting)}. Effects on a {target.kind.replace('_', ' ')}: "
        f'{", ".join(effects_on(target))}\nWrite it like "{candidates[0].example}"; robotcore faults lists all effects',
        "fault-not-on-this-kind",
    )


def _build_fault(spec: Spec, fault: type[Fault], target: FaultTarget) -> Fault:
    values = dict(spec.parameters) if spec.value is None else {**dict(spec.parameters), VALUE: spec.value}
    try:
        return fault.model_validate(values, context={"target": target.kind})
    except ValidationError as error:
        key, reason = first_mistake(error)
    if key == VALUE and (spec.value is None or VALUE not in fault.model_fields):
        mistake = f"{spec.effect} {'needs a' if spec.value is None else 'takes no'} value"
    else:
        mistake = f"{spec.effect if key == VALUE else key} {reason}".strip()
    form = " ".join([spec.target, *forms_of(spec.effect, fault)])
    raise _build_error(spec, f'{mistake}\nWrite it as "{form}"', "fault-parameter")


def _build_error(spec: Spec, reason: str, kind: str) -> UsageError:
    return UsageError(f"--fault {quote_text(str(spec))}: {reason}", kind=kind, fault=str(spec))
