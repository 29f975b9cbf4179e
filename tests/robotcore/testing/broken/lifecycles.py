from __future__ import annotations

from dataclasses import replace
from types import TracebackType

from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.display import Display
from tests.robotcore.testing.harness import Sound, broken, replace_attribute


def choose_all(setup: Setup) -> Setup:
    return replace(setup, devices=frozenset(device.name for device in setup.robot.devices))


def drop_options(setup: Setup) -> Setup:
    return replace(setup, options={})


def choose_no_device_without_a_drive(setup: Setup) -> Setup:
    return setup if setup.robot.drive else replace(setup, devices=frozenset())


def ignore_close(robot: Robot) -> None:
    replace_attribute(robot, "close", lambda: None)


def refuse_second_close(robot: Robot) -> None:
    close = robot.close

    def close_once() -> None:
        replace_attribute(robot, "close", raise_error)
        close()

    def raise_error() -> None:
        raise RuntimeError("not connected")

    replace_attribute(robot, "close", close_once)


def keep_sensor_open(robot: Robot) -> None:
    if "nose" in robot.devices:
        replace_attribute(robot["nose"], "close", lambda: None)


def keep_display_open(robot: Robot) -> None:
    for device in robot.devices.values():
        if isinstance(device, Display):
            replace_attribute(device, "close", lambda: None)


class FirstErrorRobot(Robot):
    """A robot that stops its motors in turn, until one fails."""

    def close(self) -> None:
        motors = list(self.motors.values())
        try:
            for motor in motors:
                motor.stop()
        except OSError:
            for motor in motors:
                motor._is_closed = True
            raise
        super().close()


class NoCloseOnErrorRobot(Robot):
    """A robot that closes only if nothing was raised."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()


class FirstErrorSuite(Sound):
    kind: type[Robot] = FirstErrorRobot

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        return self.kind(robot.name, robot.clock, robot.devices.values(), truth=robot.truth, release=robot.close)


class NoCloseOnErrorSuite(FirstErrorSuite):
    kind = NoCloseOnErrorRobot


class SecondOpenSuite(Sound):
    times = 0

    def open(self, setup: Setup) -> Robot:
        self.times += 1
        return super().open(setup if self.times == 1 else replace(setup, devices=setup.devices - {"screen"}))


BROKEN = (
    broken("it opens other devices too", "only_the_chosen_devices_are_opened", change_setup=choose_all),
    broken("it needs a drive", "robot_without_a_drive_opens", change_setup=choose_no_device_without_a_drive),
    broken("options are ignored", "unknown_option_is_refused", change_setup=drop_options),
    broken(
        "closing does nothing",
        "closing_stops_every_motor exception_in_the_with_block_stops_every_motor closed_device_refuses_use "
        "other_motor_stops_if_one_fails_to_stop",
        ignore_close,
    ),
    broken("closing twice fails", "closing_twice_is_no_error", refuse_second_close),
    broken("a closed sensor still returns samples", "closed_device_refuses_use", keep_sensor_open),
    broken("a closed display still shows pictures", "closed_device_refuses_use", keep_display_open),
    broken(
        "one motor that fails keeps the next from stopping",
        "other_motor_stops_if_one_fails_to_stop",
        suite=FirstErrorSuite,
    ),
    broken(
        "an error leaves the motors turning", "exception_in_the_with_block_stops_every_motor", suite=NoCloseOnErrorSuite
    ),
    broken(
        "a robot cannot be opened again",
        "robot_opens_again_after_closing only_the_chosen_devices_are_opened",
        suite=SecondOpenSuite,
    ),
)
