"""What a board's devices read once it is back: nothing that was told before it was lost, however short the outage."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from robotcore.description import BatteryDescription
from robotcore.errors import DeviceLostError
from robotcore.hal.devices import Motor, Sensor
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rig import Rig
from tests.doubles.serial.rosarduino import OurDouble, TrueDouble
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.doubles.serial.wheels import Wheels

BATTERY = BatteryDescription(kind="battery", name="battery")


def devices(board: str, motor: dict[str, Any], **others: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the sections of two motors, their encoders, and others, on one board."""
    return {
        **{f"{side}_motor": {"driver": f"{board}-motor", "side": side, **motor} for side in ("left", "right")},
        **{f"{side}_encoder": {"driver": f"{board}-encoder", "side": side} for side in ("left", "right")},
        **{name: {"driver": f"{board}-{'sonar' if name == 'nose' else name}", **told} for name, told in others.items()},
    }


BOARDS: dict[str, tuple[Callable[[], BoardDouble], dict[str, dict[str, Any]]]] = {
    "our firmware": (OurDouble, devices("ros-arduino", {}, nose={}, battery={})),
    "ROSArduinoBridge": (TrueDouble, devices("ros-arduino", {}, nose={"pin": 7})),
    "waveshare": (WaveshareBoard, devices("waveshare", {}, battery={})),
    "hoverboard": (lambda: Hoverboard(Wheels()), devices("hoverboard", {"mode": "speed"}, battery={})),
}


@pytest.mark.parametrize("name", BOARDS)
def test_nothing_that_was_told_before_the_board_was_lost_is_read_when_it_is_back(tmp_path: Path, name: str) -> None:
    make, told = BOARDS[name]
    with closing(Rig(tmp_path, make(), told, (BATTERY,))) as rig:
        sensors = [device for device in rig.robot.devices.values() if not isinstance(device, Motor)]
        rig.pass_by(0.1)
        rig.pty.unplug()
        rig.pass_by(2.0)
        rig.pty.plug_in()
        back_at, read = rig.clock.now(), set()
        for _ in range(600):
            rig.pass_by(0.002)
            for sensor in sensors:
                assert isinstance(sensor, Sensor)
                with suppress(DeviceLostError):
                    assert sensor.read().time > back_at - 0.5, f"{sensor.name} at {rig.clock.now() - back_at:g} s"
                    read.add(sensor)
        assert read == set(sensors)
