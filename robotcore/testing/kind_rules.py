"""Rules for devices of every kind, and the rules that a kind brings itself."""

from __future__ import annotations

from typing import get_type_hints

from robotcore.hal.device import list_values
from robotcore.hal.kind import load_kind
from robotcore.testing.bench import TestBench, list_sensors


class KindRules(TestBench):
    """Tests that the driver of every device must pass."""

    def test_values_have_the_types_of_the_sample(self) -> None:
        with self.open_robot() as robot:
            for sensor in list_sensors(robot):
                sample, kind = sensor.read(), load_kind(sensor.kind)
                types = get_type_hints(kind.sample)
                for field, _ in list_values(kind.sample):
                    value, expected = getattr(sample, field), types[field]
                    is_right = isinstance(value, bool) is (expected is bool) and isinstance(value, (int, float))
                    assert is_right, (
                        f"{sensor.name}: {field} of its sample is {value!r}, of the type {type(value).__name__}. "
                        f"Return a {expected.__name__}"
                    )

    def test_devices_follow_the_rules_of_their_kinds(self) -> None:
        for description in self.description.devices:
            if description.name in self.openable:
                for rule in load_kind(description.kind).rules:
                    with self.open_robot() as robot:
                        rule(robot, robot[description.name])
