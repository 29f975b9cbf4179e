from __future__ import annotations

import pytest

from drivers.raspberrypi import claiming
from drivers.raspberrypi.claiming import pin_failure
from robotcore.errors import DeviceClosedError, DeviceError


def test_a_busy_gpio_is_told_with_who_holds_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claiming, "held_by", lambda gpio: f"process {1000 + gpio} (python3)")
    with pytest.raises(DeviceError) as told, claiming.claiming("left_motor", (17,)):
        raise LgpioError("GPIO busy")
    assert str(told.value) == "left_motor: GPIO 17 is held by process 1017 (python3). End that program first"
    assert isinstance(told.value.__cause__, LgpioError)


def test_anything_else_is_told_with_the_gpios_the_cause_and_what_to_do() -> None:
    failure = pin_failure("nose", (16, 26), LgpioError("bad handle"))
    assert str(failure) == (
        "nose: GPIO 16, 26 failed (LgpioError: 'bad handle'). "
        "Look at the wiring in the robot's file, and run robotcore doctor"
    )


def test_an_error_of_ours_stays_what_it_is() -> None:
    closed = DeviceClosedError("nose")
    with pytest.raises(DeviceClosedError) as told, claiming.claiming("nose", (16,)):
        raise closed
    assert told.value is closed


class LgpioError(Exception):
    """Tells of itself as lgpio's error does: in quotes."""

    def __str__(self) -> str:
        return repr(self.args[0])
