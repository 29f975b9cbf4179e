"""A row of reflectance sensors that look down at the floor, for following a line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from robotcore.description import Ideal, Mount, SensorDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.device_test import IN_OTHER_ORDER, INVERTED, DeviceTest
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Darkness", "LineSensor", "LineSensorDescription"]

LUMINANCE = np.array((0.299, 0.587, 0.114)) / 255
"""The weights of red, green and blue in the brightness of a surface. Source: ITU-R BT.601."""

THRESHOLD = 0.5
"""A sensor sees the line if its darkness is greater."""


class LineSensorDescription(SensorDescription):
    """A row of reflectance sensors across the robot. The mount is the middle of the row.

    >>> from robotcore.description import Mount
    >>> row = LineSensorDescription(kind="line_sensor", name="row", mount=Mount(z_m=0.01), count=5, spacing_m=0.016)
    >>> row.arguments()
    {'count': 5, 'spacing': 0.016}
    """

    kind: Literal["line_sensor"]
    mount: Mount
    count: Annotated[int, Field(ge=1, le=64)]
    """The number of sensors in the row."""
    spacing_m: Annotated[float, Field(ge=0.001, le=1)]
    """The distance between the middles of two neighbouring sensors, in metres."""
    noise: Annotated[float, Field(ge=0, le=1), Ideal(0.0)] = 0.0
    """The standard deviation of each darkness of a simulated row."""

    def arguments(self) -> dict[str, Any]:
        return {"count": self.count, "spacing": self.spacing_m}


@dataclass(frozen=True, slots=True)
class Darkness:
    """A sample of a line sensor.

    >>> Darkness(values=(0.0, 0.9, 0.1), time=1.25, sequence=25)
    Darkness 0.00 0.90 0.10 at 1.25 s
    """

    values: Annotated[tuple[float, ...], Unit("")]
    """The darkness under each sensor from left to right: 0 for white, 1 for black. Digital sensors have 0 or 1."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class LineSensor(Sensor[Darkness]):
    """A row of reflectance sensors that look down at the floor.

    count: the number of sensors.
    spacing: the distance between neighbours in metres.

    ``mount`` is the middle of the row on the robot in the plane. A run sets it from the robot's description.

    >>> from robotcore.description import Mount
    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.line_sensor import Darkness, LineSensorDescription
    >>> row = LineSensorDescription(kind="line_sensor", name="row", mount=Mount(z_m=0.01), count=3, spacing_m=0.01)
    >>> build_sensor(row, lambda: Darkness((1.0, 0.2, 0.0), 0.0, 0)).read_position()
    0.01
    """

    kind = "line_sensor"

    def __init__(self, name: str, *, count: int, spacing: float) -> None:
        super().__init__(name)
        self.count, self.spacing = count, spacing

    def limit_sample(self, sample: Darkness) -> Darkness:
        return replace(sample, values=limit_darkness(sample.values))

    def read_position(self, threshold: float = THRESHOLD) -> float | None:
        """Return the position of the line in the newest sample in metres, positive to the left of the row's middle.

        It is the mean of the positions of the sensors, weighted by the part of their darkness above the threshold. The
        result is None if no sensor sees a line.

        threshold: a sensor sees the line if its darkness is greater.
        """
        weights = [max(value - threshold, 0.0) for value in self.read().values]
        if not any(weights):
            return None
        places = compute_offsets(self.count, self.spacing)
        return sum(map(float.__mul__, weights, places)) / sum(weights)


def compute_offsets(count: int, spacing: float) -> list[float]:
    """Return how far each sensor of a row is to the left of the middle, from left to right, in metres."""
    return [((count - 1) / 2 - index) * spacing for index in range(count)]


def limit_darkness(values: Iterable[float]) -> tuple[float, ...]:
    """Return the values of darkness, each limited to 0 for white and 1 for black."""
    return tuple(max(0.0, min(value, 1.0)) for value in values)


def simulate(sensor: LineSensorDescription, state: SimulationState) -> Callable[[float, int], Darkness]:
    """Return a function that takes a sample: the darkness of one point of the floor under each sensor.

    A dark object that a simulated person holds under one sensor hides the floor.
    """
    offsets = compute_offsets(sensor.count, sensor.spacing_m)

    def take(time: float, sequence: int) -> Darkness:
        if (covered := state.touches.get(sensor.name)) is not None:
            return Darkness(tuple(float(number == covered) for number in range(sensor.count)), time, sequence)
        middle = state.joints.locate(sensor.mount).pose
        points = [middle.to_world(0.0, offset) for offset in offsets]
        darkness = 1.0 - state.measure_floor_colours(points) @ LUMINANCE
        darkness += state.draw_noises(sensor.name, sensor.noise, time, sensor.count)
        return Darkness(limit_darkness(darkness.tolist()), time, sequence)

    return take


def validate_sample(sensor: LineSensorDescription, sample: Darkness) -> Darkness:
    """Return a scripted sample. Raises ValueError unless it has a number from 0 to 1 for each sensor."""
    values: Any = sample.values
    form = f"a list of tuples of {sensor.count} numbers from 0 to 1"
    if not isinstance(values, (tuple, list)) or len(values) != sensor.count:
        raise ValueError(form)
    if not all(isinstance(value, (int, float)) for value in values) or limit_darkness(values) != tuple(values):
        raise ValueError(form)
    return replace(sample, values=tuple(map(float, values)))


MAX_TESTED = 8
"""The greatest number of sensors of a row that a person covers one after the other. Of more, only the ends are."""

COVER_S = 0.3
"""The time for which a sensor is covered before it is read, in seconds."""


def test_rows(test: DeviceTest, rows: Sequence[Any]) -> None:
    """Let the person hold something black under each sensor of a row, above a white floor."""
    for row in rows:
        device = test.robot.devices[row.name]
        assert isinstance(device, LineSensor)
        numbers = list(range(row.count)) if row.count <= MAX_TESTED else [0, row.count - 1]
        reactions = [_cover(test, device, number) for number in numbers]
        if None in reactions:
            test.skip(row.name, "no person covers its sensors")
            continue
        _report_row(test, row, numbers, [reaction for reaction in reactions if reaction is not None])


def _cover(test: DeviceTest, row: LineSensor, number: int) -> tuple[bool, ...] | None:
    """Return which sensors see black while the person covers one; None if no person does it."""

    def hold(state: SimulationState) -> None:
        state.touches[row.name] = number

    place = f"sensor {number + 1} of {row.count} from the left"
    text = f"Put {row.name} above a white floor. Hold something black under {place}"
    if not test.instruct(row.name, f"cover{number + 1}", text, hold):
        return None
    test.wait(COVER_S)
    values = row.read().values
    if test.state:
        test.state.touches.clear()
    return tuple(value > THRESHOLD for value in values)


def _report_row(
    test: DeviceTest, row: LineSensorDescription, numbers: Sequence[int], reactions: Sequence[tuple[bool, ...]]
) -> None:
    is_inverted = sum(map(sum, reactions)) > len(reactions) * row.count / 2
    seen = [[index for index, is_black in enumerate(each) if is_black is not is_inverted] for each in reactions]
    if is_inverted:
        test.correct(row.name, "sees black as white", INVERTED, remedy="Swap its settings", kind="row-inverted")
    if any(len(each) != 1 for each in seen):
        dead = [number + 1 for number, each in zip(numbers, seen, strict=True) if not each]
        text = f"does not react under sensor {', '.join(map(str, dead))}" if dead else "several sensors react at once"
        test.fail(row.name, text, "Check the wires, and turn the potentiometer of each sensor", "row-unclear")
        return
    order = [each[0] for each in seen]
    if order == list(numbers):
        if not is_inverted:
            test.confirm(row.name, "each sensor reacts to black")
    elif sorted(order) == list(range(row.count)):
        text = f"the sensors are in another order: {', '.join(str(number + 1) for number in order)}"
        test.correct(row.name, text, IN_OTHER_ORDER, order, remedy="Correct the order", kind="row-order")
    else:
        text = "is reversed" if order == list(numbers)[::-1] else "has another order"
        order = list(range(row.count))[::-1]
        test.correct(row.name, text, IN_OTHER_ORDER, order, remedy="Correct the order", kind="row-order")


KIND = Kind(
    "a row of sensors of the floor's darkness",
    LineSensorDescription,
    LineSensor,
    Darkness,
    simulate,
    default_reading=lambda sensor: {"values": (0.0,) * sensor.count},
    validate_sample=validate_sample,
    test_devices=test_rows,
)
"""The kind `line_sensor`, which the entry point of this name refers to."""
