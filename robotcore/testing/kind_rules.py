"""Rules for devices of every kind, and the rules that a kind brings itself."""

from __future__ import annotations

from typing import Any, TypeGuard, get_args, get_origin, get_type_hints

from robotcore.hal.device import Actuator, Device, list_values
from robotcore.hal.kind import load_kind
from robotcore.kinds.motor import Motor
from robotcore.testing.bench import TestBench, list_sensors
from robotcore.testing.fakes import CommandSpy


class KindRules(TestBench):
    """Tests that the driver of every device must pass."""

    def test_values_have_the_types_of_the_sample(self) -> None:
        with self.open_robot() as robot:
            for sensor in list_sensors(robot):
                sample, kind = sensor.read(), load_kind(sensor.kind)
                types = get_type_hints(kind.sample)
                for field, _ in list_values(kind.sample):
                    value, expected = getattr(sample, field), types[field]
                    assert _is_of_type(value, expected), (
                        f"{sensor.name}: {field} of its sample is {value!r}, of the type {type(value).__name__}. "
                        f"Return a {_name_type(expected)}"
                    )

    def test_stop_and_closing_send_only_the_safe_command(self) -> None:
        robot = self.open_robot()
        spies = {each: CommandSpy(each) for each in robot.devices.values() if _is_actuator(each)}
        for actuator in spies:
            actuator.stop()
        robot.close()
        for actuator, spy in spies.items():
            safe = actuator.safe_command
            expected = "nothing" if safe is None else f"its safe command {safe}"
            is_right = not spy.sent if safe is None else {*spy.sent} == {safe}
            assert is_right, f"{actuator.name}: stop() and close() sent {spy.sent}. Send {expected}"

    def test_devices_follow_the_rules_of_their_kinds(self) -> None:
        for description in self.description.devices:
            if description.name in self.openable:
                for rule in load_kind(description.kind).rules:
                    with self.open_robot() as robot:
                        rule(robot, robot[description.name])


def _is_actuator(device: Device) -> TypeGuard[Actuator[Any]]:
    return isinstance(device, Actuator) and not isinstance(device, Motor)  # motors have rules of their own


def _is_of_type(value: object, expected: Any) -> bool:
    if get_origin(expected) is tuple:
        return isinstance(value, tuple) and all(_is_of_type(item, get_args(expected)[0]) for item in value)
    return isinstance(value, bool) is (expected is bool) and isinstance(value, (int, float))


def _name_type(expected: Any) -> str:
    return "tuple of numbers" if get_origin(expected) is tuple else str(expected.__name__)
