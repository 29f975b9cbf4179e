"""A simulated robot has real devices of input, and no others. With a gamepad: tests/drivers/raspberrypi."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hal.backend import load_backend
from robotcore.hardware import Connection
from tests.robotcore.hardware.device_drivers import MotorPlug, Plug, register, robot_file
from tests.texts import Raises

NECK = '[kinematic.neck]\ndriver = "motor-plug"\npin = 1\n'
EYE = '[kinematic.eye]\ndriver = "plug"\npin = 2\n'


@pytest.mark.parametrize("tables, bus, kind", [(EYE, "GPIO", "unknown-pin"), (NECK, "input", "real-actuator")])
def test_device_on_pins_and_an_actuator_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises, tables: str, bus: str, kind: str
) -> None:
    register(monkeypatch)
    for driver in (Plug, MotorPlug):
        monkeypatch.setattr(driver, "connections", lambda _self: (Connection("pin", bus, "1"),))
    file = tmp_path / "post.toml"
    file.write_text(robot_file(tables))
    with raises(DescriptionError, kind):
        load_backend("kinematic").check(load_robot(str(file)))
