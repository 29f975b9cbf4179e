from __future__ import annotations

from unittest.mock import Mock

import pytest

from robotcore.errors import DescriptionError, DeviceError, DeviceLostError
from robotcore.hardware import bind_devices
from robotcore.kinds.encoder import Angle
from tests.drivers.raspberrypi.motors.rig import H_BRIDGE, QUADRATURE, Rig, rover
from tests.texts import Raises

CONTROLLED = {**H_BRIDGE, "control": {}}
WEAK = {"forward_rad_s": 14.0 * 0.7, "backward_rad_s": 14.0 * 0.7}
SPEED = 6.0
SETTLED_S = 2.0


@pytest.mark.parametrize("speed", [SPEED, -SPEED, 1.0])
@pytest.mark.parametrize("slots", [960, 240, 20])
def test_control_makes_a_wheel_with_less_gain_turn_as_commanded(speed: float, slots: int) -> None:
    rig = Rig(CONTROLLED, slots=slots, wheel=WEAK)
    turned, _ = drive(rig, speed)
    assert turned == pytest.approx(speed, rel=0.03)


def test_missed_rotation_at_the_limit_is_not_corrected_later() -> None:
    rig = Rig(CONTROLLED, wheel={"forward_rad_s": 8.0})
    drive(rig, 12.0)
    assert rig.duty() == 1.0
    rig.motor.set_velocity(3.0)
    rig.pass_time(1.0)
    assert rig.velocity == pytest.approx(3.0, rel=0.05)


def test_a_stop_is_immediate_and_final() -> None:
    rig = Rig(CONTROLLED, wheel=WEAK)
    drive(rig, SPEED)
    rig.motor.stop()
    duties: list[float] = [rig.duty()]
    rig.on_step = lambda: duties.append(rig.duty())
    rig.pass_time(0.5)
    assert set(duties) == {0.0}


def test_a_stop_between_the_reading_and_the_correction_wins() -> None:
    rig = Rig(CONTROLLED, wheel=WEAK)
    drive(rig, SPEED)
    read = rig.encoder._newest

    def read_and_stop() -> Angle:
        sample = read()
        rig.encoder._newest = read  # type: ignore[method-assign]
        rig.motor.stop()
        return sample

    rig.encoder._newest = read_and_stop  # type: ignore[method-assign]
    rig.pass_time(0.06)
    assert rig.duty() == 0.0


@pytest.mark.parametrize("again", [SPEED, -SPEED])
def test_the_correction_is_reset_at_a_stop_and_at_a_change_of_direction(again: float) -> None:
    rig, fresh = Rig(CONTROLLED, wheel=WEAK), Rig(CONTROLLED, wheel=WEAK)
    drive(rig, SPEED)
    corrected = abs(rig.duty())
    if again > 0:
        rig.motor.stop()
    rig.motor.set_velocity(again)
    fresh.motor.set_velocity(again)
    assert rig.duty() == fresh.duty()
    assert abs(rig.duty()) < corrected - 0.05


def test_a_command_that_changes_the_velocity_keeps_the_correction() -> None:
    rig, fresh = Rig(CONTROLLED, wheel=WEAK), Rig(CONTROLLED, wheel=WEAK)
    drive(rig, SPEED)
    rig.motor.set_velocity(SPEED / 2)
    fresh.motor.set_velocity(SPEED / 2)
    assert rig.duty() > fresh.duty() + 0.05


def test_an_encoder_that_fails_stops_the_motor_and_the_next_command_raises(raises: Raises) -> None:
    rig = Rig(CONTROLLED)
    drive(rig, SPEED)
    rig.encoder._newest = Mock(side_effect=DeviceError("left_encoder", "unplugged"))  # type: ignore[method-assign]
    rig.pass_time(0.06)
    assert rig.duty() == 0.0
    rig.motor.stop()
    with raises(DeviceError):
        rig.motor.set_velocity(SPEED)
    assert rig.duty() == 0.0


def test_after_a_lost_encoder_works_again_missed_rotation_is_not_corrected() -> None:
    rig, fresh = Rig(CONTROLLED), Rig(CONTROLLED)
    drive(rig, SPEED)
    whole = rig.encoder._newest
    rig.encoder._newest = Mock(side_effect=DeviceLostError("left_encoder", "unplugged"))  # type: ignore[method-assign]
    rig.pass_time(1.0)
    for _ in range(2):
        with pytest.raises(DeviceLostError):
            rig.motor.set_velocity(SPEED)
        assert rig.duty() == 0.0
    rig.pass_time(1.01)
    rig.encoder._newest = whole  # type: ignore[method-assign]
    duties: list[list[float]] = [[], []]
    for each, seen in zip((rig, fresh), duties, strict=True):
        for _ in range(5):
            each.motor.set_velocity(SPEED)
            each.pass_time(0.04)
            seen.append(each.duty())
    assert duties[0] == pytest.approx(duties[1], rel=0.05)


def test_control_without_an_encoder_on_the_wheel_is_refused(raises: Raises) -> None:
    robot = rover({"left_motor": CONTROLLED, "left_encoder": QUADRATURE})
    assert robot.drive
    bare = robot.model_copy(
        update={"drive": robot.drive.model_copy(update={"left_encoder": None, "right_encoder": None})}
    )
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(bare, "raspberrypi", ["left_motor"])


def test_a_motor_whose_encoder_is_not_open_cannot_be_controlled(raises: Raises) -> None:
    with raises(DeviceError, "encoder-not-open"):
        Rig(CONTROLLED, names=("left_motor",))


def drive(rig: Rig, speed: float) -> tuple[float, list[float]]:
    """Return the mean velocity of the settled wheel, and that of each step."""
    velocities: list[float] = []
    for second in (SETTLED_S, 1.0):
        rig.on_step = lambda: velocities.append(rig.velocity)
        for _ in range(int(second / 0.04)):
            rig.motor.set_velocity(speed)
            rig.pass_time(0.04)
    last = velocities[-250:]
    rig.on_step = lambda: None
    return sum(last) / len(last), last
