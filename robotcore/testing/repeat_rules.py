"""The rule for simulators in lockstep: two runs with equal commands are equal to the bit."""

from __future__ import annotations

from typing import Any

from robotcore.description import CameraDescription, WorldDescription
from robotcore.hal.backend import Vouch
from robotcore.hal.devices import Frame
from robotcore.hal.robot import Robot
from robotcore.testing import scenes
from robotcore.testing.bench import RATE_HZ, Bench, Capability, sensors_of

TICKS = 10


class RepeatRules(Bench):
    """What every simulator owes that vouches for lockstep."""

    def test_two_runs_alike_are_equal_to_the_bit(self) -> None:
        self.require(Vouch.LOCKSTEP, Capability.REPRODUCIBLE)
        first, second = self._all_said(), self._all_said()
        parted = [name for name in first if first[name] != second[name]]
        assert not parted, (
            f"two runs with equal commands parted: {', '.join(parted)}; look for time, threads, a random generator "
            "without the run's seed, or state that outlives closing"
        )

    def _all_said(self) -> dict[str, list[Any]]:
        """Return all that a short run reads, by device."""
        said: dict[str, list[Any]] = {}
        with self.opened(self._world()) as robot:
            for tick in range(1, TICKS + 1):
                self._steer(robot, tick)
                robot.clock.sleep_until(tick / RATE_HZ)
                for sensor in sensors_of(robot):
                    said.setdefault(sensor.name, []).append(_content(sensor.read()))
                if robot.truth:
                    said.setdefault("the true pose", []).append(robot.truth.pose())
        return said

    def _world(self) -> WorldDescription | None:
        eye = self.description.first_of(CameraDescription)
        return scenes.ball(eye.mount, 0.9, 0.2) if eye else None

    def _steer(self, robot: Robot, tick: int) -> None:
        if self.description.drive:
            self.command(robot, 1.0 + 0.3 * tick, 4.0 - 0.2 * tick, seconds=0.0)


def _content(sample: Any) -> Any:
    """Return what of a sample can be compared."""
    return (sample.time, sample.image.tobytes()) if isinstance(sample, Frame) else sample
