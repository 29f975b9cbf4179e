"""The model of a PCA9685, and robots on virtual pins with motors and servos on its channels."""

from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.pwm.chip import PwmChip, WrongChipError, require_pwm_chip
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from drivers.raspberrypi.virtual.pwm_chip import VirtualPwmChip
from robotcore import RunRequest, run
from robotcore.description import load_robot
from robotcore.hal.backend import Setup
from robotcore.kinds import Servo
from robotcore.kinds.servo import ServoDescription
from robotcore.testing import worlds

MODEL = {"forward_rad_s": 14.0, "backward_rad_s": 14.0}


def test_outputs_are_off_until_the_chip_is_set_up_and_after_a_reset() -> None:
    registers = VirtualPwmChip()
    chip = PwmChip(registers)
    registers.write(0x06, 0, 0x10, 0, 0)
    assert registers.channels[0].state == 0.0
    chip.begin(50)
    assert registers.frequency_hz == pytest.approx(50, rel=0.01)
    for duty in (0.25, 1.0, 0.0):
        chip.set_duty(3, duty)
        assert registers.channels[3].state == duty
    chip.set_duty(3, 1.0)
    registers.reset()
    assert registers.channels[3].state == 0.0


def test_values_of_one_transfer_stay_in_one_register_without_auto_increment() -> None:
    registers = VirtualPwmChip()
    registers.write(0x06, 1, 2, 3, 4)
    assert [registers.read(0x06 + at) for at in range(4)] == [4, 0, 0, 0x10]
    PwmChip(registers).begin(50)
    registers.write(0x06, 1, 2, 3, 4)
    assert [registers.read(0x06 + at) for at in range(4)] == [1, 2, 3, 4]


def test_registers_of_another_chip_are_recognised() -> None:
    registers = VirtualPwmChip()
    require_pwm_chip(registers)
    registers.write(0x07, 0x40)
    with pytest.raises(WrongChipError):
        require_pwm_chip(registers)


@pytest.mark.slow
@pytest.mark.parametrize("app, robot", [("green-search", "jetbot"), ("pan-search", "freenove-4wd")])
def test_app_finds_the_ball_with_the_motors_and_servos_of_a_kit(app: str, robot: str) -> None:
    result = run(RunRequest(app, "virtualpi", robot=robot, seed=7))
    assert result.verified
    assert result.contacts == 0


def build_setup(tables: dict[str, Any], *devices: str) -> Setup:
    rover = load_robot("rover")
    limits = {"min_angle_rad": -1.0, "max_angle_rad": 1.0, "max_velocity_rad_s": 50.0}
    pan = ServoDescription.model_validate({"kind": "servo", "name": "pan", **limits})
    backends = {"raspberrypi": {**rover.backends["raspberrypi"], **tables}}
    robot = rover.model_copy(update={"devices": (*rover.devices, pan), "backends": backends})
    return Setup(robot, worlds.empty(), frozenset(devices))


def test_motors_servo_and_gpio_share_a_chip() -> None:
    shared = {"address": 0x40, "frequency_hz": 50, "model": MODEL}
    tables = {
        "left_motor": {"driver": "pca9685-phase-motor", "pwm": 4, "phase": 17, "forward_is_high": True, **shared},
        "right_motor": {"driver": "pca9685-motor", "forward": 5, "backward": 6, **shared},
        "pan": {"driver": "pca9685-servo", "channel": 0},
    }
    setup = build_setup(tables, "left_motor", "right_motor", "left_encoder", "right_encoder", "pan")
    with VirtualPiBackend().open(setup) as robot:
        pan = robot["pan"]
        assert isinstance(pan, Servo)
        robot.motors["left_motor"].set_velocity(-6.0)
        robot.motors["right_motor"].set_velocity(6.0)
        pan.set_angle(0.5)
        robot.clock.sleep_until(1.0)
        left, right = (robot[f"{side}_encoder"].read().angle for side in ("left", "right"))  # type: ignore[attr-defined]
        assert (left, right) == pytest.approx((-6.0, 6.0), abs=0.5)
        truth = robot.truth
        assert truth is not None
        assert truth.simulation_state.joints["pan"].angle == pytest.approx(0.5, abs=0.01)  # type: ignore[attr-defined]
