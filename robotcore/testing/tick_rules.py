"""The rule for a driver's robot under the layers of a real run."""

from __future__ import annotations

from robotcore.runtime.layers import assemble
from robotcore.testing.bench import RATE_HZ, Bench, sensors_of


class TickRules(Bench):
    """What an app relies on within a tick."""

    def test_within_a_tick_a_device_gives_one_sample(self) -> None:
        with assemble(self.opened(), self.description, RATE_HZ).robot as robot:
            for sensor in sensors_of(robot):
                first = sensor.read()
                assert all(sensor.read() is first for _ in range(3)), (
                    f"{sensor.name}: read several times in one tick, it gave different samples; derive it from "
                    "RangeSensor, Camera, Encoder or Battery, which the layers know"
                )
