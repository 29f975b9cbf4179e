"""A row of digital line sensors on mock pins, and on virtual ones in a run."""

from __future__ import annotations

from pathlib import Path

import pytest
from gpiozero.pins.mock import MockFactory

import robotcore
from robotcore import RunRequest
from robotcore.description import Mount
from robotcore.errors import DescriptionError, DeviceClosedError
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceBinding, DeviceContext, bind_devices
from robotcore.kinds import LineSensor
from robotcore.kinds.line_sensor import LineSensorDescription
from tests.drivers.raspberrypi.motors.rig import rover
from tests.robotcore.kinds.test_line_sensor import Look, write_line_rover, write_line_world
from tests.texts import Raises

WIRED = '\n[raspberrypi.row]\ndriver = "line-sensors"\ngpios = [4, 12, 13, 18, 19]\n'


def bind(**keys: object) -> tuple[DeviceBinding, DeviceContext]:
    row = LineSensorDescription(kind="line_sensor", name="row", mount=Mount(z_m=0.01), count=2, spacing_m=0.02)
    robot = rover({"row": {"driver": "line-sensors", "gpios": (12, 13), **keys}})
    robot = robot.model_copy(update={"devices": (row,)})
    (binding,) = bind_devices(robot, "raspberrypi")
    return binding, DeviceContext(robot, SteppedClock(20.0, lambda _steps: None), MockFactory())


@pytest.mark.parametrize("active_high", [True, False])
def test_output_over_a_line_is_read_as_black(active_high: bool) -> None:
    binding, host = bind(active_high=active_high)
    sensor = binding.open(host)
    assert isinstance(sensor, LineSensor)
    assert sensor.read().values == (0.0, 0.0)  # the pull resistors hold unplugged sensors over white
    pin = host.pins.pin(13)
    (pin.drive_high if active_high else pin.drive_low)()
    host.clock.sleep_until(0.05)
    assert sensor.read().values == (0.0, 1.0)
    assert sensor.read_position() == pytest.approx(-0.01)
    sensor.close()
    with pytest.raises(DeviceClosedError):
        sensor.read()


@pytest.mark.parametrize(
    "gpios, key, kind",
    [((12,), "raspberrypi.row", "wrong-count"), ((12, 12), "raspberrypi.row.gpios", "same-pin")],
    ids=["too few", "double"],
)
def test_gpios_of_another_number_of_sensors_are_refused(
    gpios: tuple[int, ...], key: str, kind: str, raises: Raises
) -> None:
    with raises(DescriptionError, kind, key=key):
        bind(gpios=gpios)


@pytest.mark.parametrize("active_high", ["true", "false"])
def test_sensors_on_virtual_pins_follow_the_floor(tmp_path: Path, active_high: str) -> None:
    robot = write_line_rover(tmp_path, f"{WIRED}active_high = {active_high}\n")
    result = robotcore.run(RunRequest(Look, robot=robot, backend="virtualpi", world=write_line_world(tmp_path)))
    assert result.reason == "0.04 (1.0, 0.0, 0.0, 0.0, 0.0)"
