"""A kind of device as data, and devices that are made of functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, cast

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.errors import (
    BackendMissingError,
    DeviceError,
    InvalidCommandError,
    RobotcoreError,
    UsageError,
    describe_exception,
)
from robotcore.hal.device import Actuator, Device, Sensor, build_driver_error, list_values
from robotcore.hal.sample_text import format_fields, format_repr
from robotcore.hal.sample_types import list_numbers, require_types
from robotcore.hal.sampling import capture_at_once, delay_samples
from robotcore.plugins import KINDS, load_registered

if TYPE_CHECKING:
    from robotcore.hal.device_test import DeviceTest
    from robotcore.hal.simulation_state import SimulationState

__all__ = ["Kind", "assert_limited", "assert_refused", "build_actuator", "build_sensor", "load_kind", "simulate_device"]


@dataclass(frozen=True)
class Kind:
    """A kind of device. An entry point of the group ``robotcore.kinds`` with the kind's name refers to it.

    >>> from robotcore.kinds import range_sensor
    >>> kind = range_sensor.KIND
    >>> kind.name, kind.sample.__name__, kind.is_simulated
    ('range_sensor', 'Range', True)
    """

    summary: str
    """A description of the kind in a few words, which `robotcore kinds` lists."""
    description: type[DeviceDescription]
    """The model of a device's table ``[[devices]]`` in a robot's file."""
    device: type[Device]
    """The class of the devices. Drivers inherit it."""
    sample: Any = None
    """The class of a sensor's samples: a dataclass with the fields ``time`` and ``sequence`` at the end.

    The kind gives it a short ``repr``, such as ``Range 1.24 m at 3.15 s``, and, unless the class defines it, the method
    ``format_values``, which returns ``1.24 m``. With ``@dataclass(repr=False)`` the class keeps its own ``__repr__``.
    """
    simulate: Callable[[Any, SimulationState], Callable[..., Any]] | None = None
    """Simulates a device in every simulator. Its arguments are the device's description and the simulation's state.

    For a sensor, it returns a function that takes a sample. The arguments of this function are the time in seconds and
    the sequence number. For an actuator, it returns a function that applies a command. With None, no simulator has a
    sensor of this kind, and each accepts the commands to an actuator without an effect.
    """
    rules: tuple[Callable[..., None], ...] = ()
    """The rules that the conformance kit checks for each driver. A rule is a function with ``assert``.

    Its arguments are an open robot and its device. The text of the assertion names the correction.
    """
    default_reading: Callable[[Any], Any] | None = None
    """Returns the reading of a mock sensor without a script. Its argument is the device's description.

    The reading is the value of a sample, or a mapping of field to value. With None, numbers are 0 and booleans False.
    """
    validate_sample: Callable[[Any, Any], Any] | None = None
    """Returns a sample with a scripted reading as a mock sensor returns it, such as with a copy of its picture.

    Its arguments are the device's description and the sample. Numbers may be infinite or NaN. It raises ValueError for
    a reading that the sensor cannot have; the text is the valid form, such as ``a distance in metres``. With None, all
    finite numbers are valid. Then `Sensor.limit_sample` limits the sample.
    """
    is_optional: bool = False
    """Whether a robot runs without the device if its backend has no table for it."""
    test_devices: Callable[[DeviceTest, Sequence[Any]], None] | None = None
    """Tests the wiring and the mounting of all open devices of the kind, for `robotcore test-devices`.

    Its arguments are the test in progress, and the descriptions of the devices in the order of the robot's file. With
    None, a sensor is read, and an actuator is reported as not tested.
    """

    def __post_init__(self) -> None:
        """Raise UsageError if the classes of the kind do not fit together."""
        name = self.device.kind
        if not name or self.description.kind_name() != name:
            written = f'kind = "{name or "gripper"}" and kind: Literal["{name or "gripper"}"]'
            raise UsageError(
                f"the classes {self.device.__name__} and {self.description.__name__} have not the same kind. Write "
                f"{written} in them",
                kind="kind-names-differ",
            )
        known = {field.name for field in fields(self.sample)} if is_dataclass(self.sample) else set()
        if issubclass(self.device, Sensor) and not known >= {"time", "sequence"}:
            raise UsageError(
                f"the kind {name!r} has no dataclass of samples with the fields time and sequence. Give it one as the "
                "argument sample",
                kind="no-sample",
            )
        if known:
            self._require_valid_sample()
            self._add_text_methods()

    def _require_valid_sample(self) -> None:
        """Raise UsageError if an app could change a sample, or if a number of it has no unit."""
        name = self.sample.__name__
        if not self.sample.__dataclass_params__.frozen:
            text = f"the samples {name} of the kind {self.name!r} can be changed. Write @dataclass(frozen=True)"
            raise UsageError(text, kind="sample-not-frozen")
        known = {"time", "sequence"} | {value.field for value in list_values(self.sample)}
        if missing := [field for field in list_numbers(self.sample) if field not in known]:
            raise UsageError(
                f"the samples {name} of the kind {self.name!r} have no unit for {', '.join(missing)}. Write "
                'Annotated[float, Unit("m")], or Unit("") for a number without a unit',
                kind="no-unit",
            )

    def _add_text_methods(self) -> None:
        if not hasattr(self.sample, "format_values"):
            self.sample.format_values = format_fields
        if self.sample.__dataclass_params__.repr:
            self.sample.__repr__ = format_repr

    @property
    def is_simulated(self) -> bool:
        """Whether simulators have such devices."""
        return self.simulate is not None or not issubclass(self.device, Sensor)

    @property
    def name(self) -> str:
        """The name of the kind in robots' files, such as ``camera``."""
        return self.device.kind


def raise_not_simulated(description: DeviceDescription, _state: SimulationState) -> Callable[..., Any]:
    """Raise DeviceError. It is the `Kind.simulate` of a kind that each simulator simulates by its own code."""
    raise DeviceError(description.name, _describe_lack(description), kind="not-simulated")


def _describe_lack(description: DeviceDescription) -> str:
    return f"simulators have no {description.kind.replace('_', ' ')}. Remove it from the robot's file"


def load_kind(name: str) -> Kind:
    """Return the kind with a registered name.

    Raises UnknownNameError for an unknown name, and BackendMissingError for a kind that cannot be loaded.

    >>> load_kind("camera").device.__name__
    'Camera'
    """
    kind = load_registered("device kind", KINDS, name)
    if not isinstance(kind, Kind) or kind.name != name:
        raise BackendMissingError(
            f"the entry point of the device kind {name!r} is not a robotcore.hal.kind.Kind of this name. Correct it",
            name=name,
        )
    return kind


def list_monitored(robot: RobotDescription) -> frozenset[str]:
    """Return the names of a robot's sensors that a run reads by itself, such as batteries."""
    return frozenset(device.name for device in robot.devices if is_monitored(device))


def is_monitored(description: DeviceDescription) -> bool:
    """Return whether a run reads the described device by itself."""
    device = load_kind(description.kind).device
    return issubclass(device, Sensor) and device.is_monitored


def assert_refused(actuator: Actuator[Any], *commands: Any) -> None:
    """Check that an actuator refuses commands without a meaning, such as NaN. For the rules of a kind.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.servo import ServoDescription
    >>> limits = {"min_angle_rad": -1.5, "max_angle_rad": 1.5, "max_velocity_rad_s": 5.0}
    >>> servo = build_actuator(ServoDescription(kind="servo", name="pan", **limits), lambda rad: None)
    >>> assert_refused(servo, float("nan"), float("inf"))
    >>> try:
    ...     assert_refused(servo, 0.5)
    ... except AssertionError as error:
    ...     print(error)
    pan: the command 0.5 was accepted. Raise InvalidCommandError
    """
    for command in commands:
        try:
            actuator.send(command)
        except InvalidCommandError:
            continue
        raise AssertionError(f"{actuator.name}: the command {command} was accepted. Raise InvalidCommandError")


def assert_limited(actuator: Actuator[Any], limited: Mapping[Any, Any]) -> None:
    """Check that an actuator limits commands. For the rules of a kind.

    limited: the command that the actuator must send for each command.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.servo import ServoDescription
    >>> limits = {"min_angle_rad": -1.5, "max_angle_rad": 1.5, "max_velocity_rad_s": 5.0}
    >>> servo = build_actuator(ServoDescription(kind="servo", name="pan", **limits), lambda rad: None)
    >>> assert_limited(servo, {9.0: 1.5, -9.0: -1.5})
    """
    for command, expected in limited.items():
        sent = actuator.send(command)
        assert sent == expected, f"{actuator.name}: the command {command} was sent as {sent}. Limit it to {expected}"


def build_sensor(
    description: DeviceDescription, newest: Callable[[], Any], release: Callable[[], None] = lambda: None
) -> Sensor[Any]:
    """Return a sensor of the described kind.

    description: the description of the sensor.
    newest: returns the newest sample.
    release: releases the hardware when the sensor is closed.

    >>> from robotcore.kinds.button import ButtonDescription, Press
    >>> button = build_sensor(
    ...     ButtonDescription(kind="button", name="start"), lambda: Press(True, 1.25, 25), lambda: print("released")
    ... )
    >>> button.read().is_pressed
    True
    >>> button.close()
    released
    """
    sensor = cast("_FunctionSensor", _create(_sensor_class(description.kind), description))
    sensor._newest_sample, sensor._release_hardware = newest, release  # noqa: SLF001  attributes of _FunctionSensor
    return sensor


def build_actuator(
    description: DeviceDescription, apply: Callable[[Any], object], release: Callable[[], None] = lambda: None
) -> Actuator[Any]:
    """Return an actuator of the described kind.

    description: the description of the actuator.
    apply: applies a command that is within the actuator's limits.
    release: releases the hardware when the actuator is closed.

    >>> from robotcore.kinds.buzzer import BuzzerDescription
    >>> buzzer = build_actuator(BuzzerDescription(kind="buzzer", name="horn"), lambda hertz: print(hertz, "Hz"))
    >>> buzzer.play(440.0)
    440.0 Hz
    440.0
    >>> buzzer.close()
    0.0 Hz
    """
    actuator = cast("_FunctionActuator", _create(_actuator_class(description.kind), description))
    actuator._apply_command, actuator._release_hardware = apply, release  # noqa: SLF001  attributes of _FunctionActuator
    return actuator


def _create(device_class: Callable[..., Device], description: DeviceDescription) -> Device:
    try:
        return device_class(description.name, **description.arguments())
    except TypeError as error:  # the arguments do not fit the constructor
        model = type(description).__name__
        text = f"{error}. Let arguments() of {model} return the arguments of __init__, without the name"
        raise DeviceError(description.name, text, kind="wrong-arguments") from error
    except RobotcoreError:
        raise
    except Exception as error:
        raise build_driver_error(description.name, error) from error


def simulate_device(description: DeviceDescription, state: SimulationState) -> Device:
    """Return a device of the described kind that is simulated from the state of the simulation.

    Raises DeviceError if the kind is that of a sensor without a simulation.

    >>> import numpy as np
    >>> from robotcore.description import load_robot, load_world
    >>> from robotcore.geometry import Pose, Twist
    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.hal.simulation_state import SimulationState
    >>> state = SimulationState(
    ...     load_robot("rover"), load_world("open"), SteppedClock(20, lambda steps: None), lambda: Pose(0.0, 0.0, 0.0),
    ...     lambda: Twist(0.0, 0.0), lambda start, rays, reach: np.full(len(rays), 1.0), lambda: (), seed=7,
    ... )
    >>> simulate_device(state.robot.first_of("range_sensor"), state).read()
    Range 0.95 m at 0.00 s
    """
    kind = load_kind(description.kind)
    if not kind.is_simulated:
        raise DeviceError(description.name, _describe_lack(description), kind="not-simulated")
    if kind.simulate is None:
        return build_actuator(description, lambda _command: None)
    call = partial(_call_simulation, description)
    simulation = call(kind.simulate, description, state)
    if not callable(simulation):
        raise _build_simulation_error(description, f"returned {simulation!r} in place of a function")
    if not issubclass(kind.device, Sensor):
        return build_actuator(description, partial(call, simulation))

    def take(time: float, sequence: int) -> Any:
        sample = call(simulation, time, sequence)
        if not isinstance(sample, kind.sample):
            raise _build_simulation_error(description, f"returned {sample!r} in place of a {kind.sample.__name__}")
        if sequence == 0:
            require_types(description.name, sample)
        return sample

    samples = delay_samples(state.clock, description, capture_at_once(take))
    return build_sensor(description, samples, samples.close)


def _call_simulation(description: DeviceDescription, function: Callable[..., Any], *args: Any) -> Any:
    try:
        return function(*args)
    except (RobotcoreError, MemoryError):
        raise
    except (Exception, SystemExit) as error:
        raise _build_simulation_error(description, f"raised {describe_exception(error, __file__)}") from error


def _build_simulation_error(description: DeviceDescription, problem: str) -> DeviceError:
    text = f"the simulation of its kind, {description.kind!r}, {problem}. Correct the kind's simulate"
    return DeviceError(description.name, text, kind="simulation-failed")


class _FunctionSensor(Sensor[Any]):
    _newest_sample: Callable[[], Any]
    _release_hardware: Callable[[], None]

    def _newest(self) -> Any:
        return self._newest_sample()

    def _release(self) -> None:
        self._release_hardware()


class _FunctionActuator(Actuator[Any]):
    _apply_command: Callable[[Any], object]
    _release_hardware: Callable[[], None]

    def _apply(self, command: Any) -> None:
        self._apply_command(command)

    def _release(self) -> None:
        self._release_hardware()


@cache
def _sensor_class(kind: str) -> Callable[..., Device]:
    device: Any = load_kind(kind).device
    return type(device.__name__, (_FunctionSensor, device), {})


@cache
def _actuator_class(kind: str) -> Callable[..., Device]:
    device: Any = load_kind(kind).device
    return type(device.__name__, (_FunctionActuator, device), {})
