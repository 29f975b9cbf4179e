"""Rules for opening and closing a robot: devices, options and motors."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace

import pytest

from robotcore.description import RobotDescription
from robotcore.errors import DeviceClosedError, DeviceError, UsageError
from robotcore.hal.device import Actuator, Device, Sensor
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.motor import Motor
from robotcore.testing.bench import SETTLING_S, STANDSTILL_M, TestBench, TestSupport, sleep
from robotcore.testing.fakes import CommandSpy, cut_wire

SPEED_RAD_S = 2.0


class LifecycleRules(TestBench):
    """Tests that every driver must pass: how it opens and closes a robot."""

    def test_only_the_chosen_devices_are_opened(self) -> None:
        for wanted in ({name} for name in sorted(self.openable)):
            with self.open(self.build_setup(devices=wanted)) as robot:
                opened = set(robot.devices)
            assert opened == wanted, (
                f"the backend opened {sorted(opened)}. Open only the devices of the setup, {sorted(wanted)}"
            )

    def test_robot_without_a_drive_opens(self) -> None:
        setup = self.build_setup()
        pole = _without_drive(setup.robot)
        names = self.openable.intersection(device.name for device in pole.devices)
        with self.open(replace(setup, robot=pole, devices=names)) as robot:
            opened = set(robot.devices)
        assert opened == names, (
            f"the backend opened {sorted(opened)} of a robot without a drive. "
            f"Open the devices of the setup, {sorted(names)}"
        )

    def test_unknown_option_is_refused(self) -> None:
        setup = replace(self.build_setup(), options={**self.options, "no_such_option": "1"})
        try:
            self.open(setup).close()
        except UsageError:
            return
        pytest.fail(
            "the backend accepted the unknown option 'no_such_option'. Read options with setup.options_as(Model)"
        )

    def test_robot_opens_again_after_closing(self) -> None:
        with self.open_robot() as robot:
            first = set(robot.devices)
        with self.open_robot() as robot:
            second = set(robot.devices)
        assert second == first, (
            f"a robot that was closed and opened again has {sorted(second)} instead of {sorted(first)}. "
            "Release every device in close()"
        )

    def test_closing_stops_every_motor(self) -> None:
        robot = self.open_robot(None, Role.DRIVE)
        spies = self._start_motors(robot)
        robot.close()
        _require_stopped(spies, "close()", "Send 0 to every motor in close()")

    def test_closing_brings_the_wheels_to_rest(self) -> None:
        self.require(TestSupport.MOTION)
        robot = self.open_robot(None, Role.DRIVE)
        if self.measure_pose(robot) is None:
            robot.close()
            pytest.skip("the suite does not override measure_pose(), so nothing measures the motion of a closed robot")
        self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
        robot.close()
        sleep(robot, SETTLING_S)
        before = self.measure_pose(robot)
        sleep(robot, SETTLING_S)
        after = self.measure_pose(robot)
        assert before is not None
        assert after is not None
        assert before.distance_to(after.x, after.y) < STANDSTILL_M, (
            f"{SETTLING_S} s after close() the robot still moved from {before} to {after} in {SETTLING_S} s. "
            "Let close() wait until the hardware has the last command of every motor, a velocity of 0"
        )

    def test_closing_unplugged_hardware_is_an_error(self) -> None:
        with ExitStack() as undo:
            robot = undo.enter_context(self.open_robot(None, Role.DRIVE))
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            self.unplug(robot)
            undo.pop_all()
        try:
            robot.close()
        except DeviceError:
            return
        pytest.fail(
            "close() raised no error without hardware, although the wheels may still turn. Raise the error of each "
            "motor's last command in close(), as DeviceError"
        )

    @pytest.mark.parametrize("broken", ["left", "right"])
    def test_other_motor_stops_if_one_fails_to_stop(self, broken: str) -> None:
        robot = self.open_robot(None, Role.DRIVE)
        motors = self.get_motors(robot)
        spies = self._start_motors(robot)
        failing = motors[0] if broken == "left" else motors[-1]
        cut_wire(failing)
        with pytest.raises(DeviceError):
            robot.close()
        for name in spies.keys() - {failing.name}:
            assert spies[name].last == 0, (
                f"{failing.name} failed to stop, and the last velocity sent to {name} is "
                f"{spies[name].last} rad/s. Stop every motor before you raise the errors"
            )

    def test_exception_in_the_with_block_stops_every_motor(self) -> None:
        robot = self.open_robot(None, Role.DRIVE)
        spies = self._start_motors(robot)
        with pytest.raises(ZeroDivisionError), robot:
            raise ZeroDivisionError
        _require_stopped(spies, "an exception in the with block", "Stop every motor at the end of the block")

    def test_closing_twice_is_no_error(self) -> None:
        robot = self.open_robot()
        robot.close()
        try:
            robot.close()
        except Exception as error:  # noqa: BLE001  any exception is an error of the driver
            pytest.fail(f"the second close() raised {error!r}. Let a second close() do nothing")

    def test_closed_device_refuses_use(self) -> None:
        robot = self.open_robot()
        robot.close()
        for device in robot.devices.values():
            try:
                _use(device)
            except DeviceClosedError:
                continue
            except Exception as error:  # noqa: BLE001  any other exception is wrong
                pytest.fail(f"{device.name}: a call after close() raised {error!r}. Raise DeviceClosedError")
            pytest.fail(f"{device.name}: a call after close() raised no error. Raise DeviceClosedError")

    def _start_motors(self, robot: Robot) -> dict[str, CommandSpy]:
        """Turn all motors, and return the spies that record their commands, by the motors' names."""
        spies = {motor.name: CommandSpy(motor) for motor in self.get_motors(robot)}
        for motor in self.get_motors(robot):
            motor.set_velocity(SPEED_RAD_S)
        return spies


def _require_stopped(spies: dict[str, CommandSpy], event: str, remedy: str) -> None:
    for name, spy in spies.items():
        assert spy.last == 0, f"{name}: after {event} the last velocity sent is {spy.last} rad/s. {remedy}"


def _without_drive(robot: RobotDescription) -> RobotDescription:
    """Return the description without its drive, motors and encoders, also without their settings for backends."""
    still = tuple(device for device in robot.devices if device.kind not in ("motor", "encoder"))
    gone = {device.name for device in robot.devices} - {device.name for device in still}
    sections = {
        section: {key: value for key, value in table.items() if key not in gone}
        for section, table in robot.backends.items()
    }
    return robot.model_copy(update={"drive": None, "devices": still, "backends": sections})


def _use(device: Device) -> None:
    if isinstance(device, Motor):
        device.set_velocity(SPEED_RAD_S)
    elif isinstance(device, Actuator):
        device.send(None)  # a closed actuator checks no command
    elif isinstance(device, Sensor):
        device.read()
