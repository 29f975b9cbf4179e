"""A robot with a device of each kind that `robotcore test-devices` tests, and mistakes in its file from a seed."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import tomlkit

from drivers.raspberrypi.cameras.capture import CameraDriver
from drivers.raspberrypi.servos import PulseDriver
from robotcore.description import load_robot, read_shipped
from robotcore.hal.backend import load_backend
from robotcore.hardware import DeviceDriver, HardwareBackend

SECTION = "raspberrypi"
BACKEND = "virtualpi"

DEVICES: list[dict[str, Any]] = [
    {
        "kind": "range_sensor",
        "name": "side",
        "mount": {"y_m": 0.09, "z_m": 0.1, "yaw_rad": 1.5708},
        "min_range_m": 0.02,
        "max_range_m": 2.0,
        "cone_rad": 0.3,
    },
    {"kind": "servo", "name": "pan", "min_angle_rad": -1.2, "max_angle_rad": 1.2, "max_velocity_rad_s": 5.0},
    {"kind": "led", "name": "lamp", "is_rgb": True},
    {"kind": "led", "name": "spot"},
    {"kind": "buzzer", "name": "horn"},
    {"kind": "button", "name": "go"},
    {"kind": "button", "name": "halt"},
    {"kind": "bumper", "name": "front"},
    {"kind": "line_sensor", "name": "row", "mount": {"x_m": 0.1, "z_m": 0.01}, "count": 3, "spacing_m": 0.012},
    {"kind": "imu", "name": "gyro"},
]
"""The devices that the rover gets in addition to its own."""

TABLES: dict[str, dict[str, Any]] = {
    "side": {"driver": "hc-sr04", "trigger": 14, "echo": 15, "echo_free_cycles": 5},
    "pan": {"driver": "servo", "gpio": 18},
    "lamp": {"driver": "rgb-led", "red": 12, "green": 13, "blue": 19},
    "spot": {"driver": "led", "gpio": 1},
    "horn": {"driver": "buzzer", "gpio": 25},
    "go": {"driver": "button", "gpio": 4},
    "halt": {"driver": "button", "gpio": 7},
    "front": {"driver": "switch", "gpio": 8},
    "row": {"driver": "line-sensors", "gpios": [9, 10, 11]},
    "gyro": {"driver": "mpu6050"},
}

Table = dict[str, Any]


def build_true_robot() -> Table:
    """Return the content of the file of the true robot."""
    robot: Table = tomlkit.parse(read_shipped("rover")).unwrap()
    robot["devices"] += deepcopy(DEVICES)
    robot[SECTION] |= deepcopy(TABLES)
    robot[SECTION]["nose"]["echo_free_cycles"] = 5  # two modules measure in turn
    return {key: value for key, value in robot.items() if key not in ("serial", "vrep")}


def draw_mistakes(robot: Table, random_: random.Random) -> tuple[Table, list[str]]:
    """Return the content with mistakes, and a word for each."""
    wrong: Table = tomlkit.parse(tomlkit.dumps(robot)).unwrap()
    tables, words = wrong[SECTION], []
    for word, change in MISTAKES.items():
        if random_.random() < 0.5:
            change(tables, random_)
            words.append(word)
    return wrong, words


def _swap(*names: str) -> Callable[[Table, random.Random], None]:
    def change(tables: Table, _random: random.Random) -> None:
        first, second = names
        tables[first], tables[second] = tables[second], tables[first]

    return change


def _exchange(device: str, first: str, second: str) -> Callable[[Table, random.Random], None]:
    def change(tables: Table, _random: random.Random) -> None:
        table = tables[device]
        table[first], table[second] = table[second], table[first]

    return change


def _set(device: str, key: str, value: Any) -> Callable[[Table, random.Random], None]:
    def change(tables: Table, _random: random.Random) -> None:
        tables[device][key] = value

    return change


def _shuffle_colours(tables: Table, random_: random.Random) -> None:
    pins = [12, 13, 19]
    while pins == [12, 13, 19]:
        random_.shuffle(pins)
    tables["lamp"].update(zip(("red", "green", "blue"), pins, strict=True))


def _shuffle_row(tables: Table, random_: random.Random) -> None:
    while tables["row"]["gpios"] == [9, 10, 11]:
        random_.shuffle(tables["row"]["gpios"])


def _change_pulses(tables: Table, random_: random.Random) -> None:
    tables["pan"].update(min_pulse_s=random_.uniform(0.0006, 0.0009), max_pulse_s=random_.uniform(0.0022, 0.0026))


MISTAKES: dict[str, Callable[[Table, random.Random], None]] = {
    "motors swapped": _swap("left_motor", "right_motor"),
    "left motor reversed": _exchange("left_motor", "forward", "backward"),
    "right motor reversed": _exchange("right_motor", "forward", "backward"),
    "encoders swapped": _swap("left_encoder", "right_encoder"),
    "left encoder reversed": _exchange("left_encoder", "a", "b"),
    "right encoder reversed": _exchange("right_encoder", "a", "b"),
    "camera mirrored": _set("eye", "flip_horizontal", True),
    "camera upside down": _set("eye", "flip_vertical", True),
    "camera colours": _set("eye", "swap_red_blue", True),
    "range sensors swapped": _swap("nose", "side"),
    "servo pulses": _change_pulses,
    "light colours": _shuffle_colours,
    "light inverted": _set("lamp", "active_high", False),
    "second light inverted": _set("spot", "active_high", False),
    "buttons swapped": _swap("go", "halt"),
    "row shuffled": _shuffle_row,
    "row inverted": _set("row", "active_high", False),
    "IMU upside down": _set("gyro", "is_upside_down", True),
}
"""Functions that make a mistake in the tables of the devices."""


def find_differences(corrected: str, true: str) -> list[str]:
    """Return the devices whose settings differ in two files in an effect on the robot."""
    drivers = [_load_drivers(file) for file in (corrected, true)]
    return [name for name, driver in drivers[1].items() if not _is_equivalent(drivers[0][name], driver)]


def _load_drivers(file: str) -> dict[str, DeviceDriver]:
    backend = load_backend(BACKEND)
    assert isinstance(backend, HardwareBackend)
    return {binding.name: binding.driver for binding in backend.bind(load_robot(file))}


def _is_equivalent(first: DeviceDriver, second: DeviceDriver) -> bool:
    if isinstance(first, CameraDriver) and isinstance(second, CameraDriver):
        return first.transformation == second.transformation
    if isinstance(first, PulseDriver) and isinstance(second, PulseDriver):
        return all(abs(a - b) < 2e-5 for a, b in zip(first.pulses, second.pulses, strict=True))
    return first == second
