from __future__ import annotations

from contextlib import ExitStack
from typing import cast

import pytest

from robotcore.errors import DeviceError, GuardianError
from robotcore.geometry import Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.runtime.layers import assemble
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.guardian import GuardianLayer, guard_motors
from robotcore.safety.command_filter import CommandFilter
from robotcore.safety.deadman import LOCK_TIMEOUT_S
from robotcore.safety.guardian.client import Guardian
from robotcore.safety.guardian.protocol import GuardianReply
from tests.robotcore.fakes import UNHURRIED, NullMotor, Rig


class GuardianSpy:
    """A guardian that logs its calls and the commands of motors in one list."""

    def __init__(self) -> None:
        self.log: list[str] = []
        self.is_dead = False
        self.reports: list[GuardianReply] = []

    def renew_lease(self) -> bool:
        self._require_life()
        self.log.append("driving")
        return True

    def end_lease(self) -> None:
        self.log.append("resting")

    def stops(self) -> list[GuardianReply]:
        self._require_life()
        reports, self.reports = self.reports, []
        return reports

    def motor(self, name: str) -> NullMotor:
        motor = NullMotor(name)
        motor.on_command = lambda rad_s: self.log.append(f"{name} {rad_s:g}")
        return motor

    def _require_life(self) -> None:
        if self.is_dead:
            raise GuardianError("dead")


class GuardedMotors:
    """Two motors under the guardian's layer."""

    def __init__(self) -> None:
        self.guardian = GuardianSpy()
        self.left, self.right = self.guardian.motor("left"), self.guardian.motor("right")
        self.layer = GuardianLayer(cast("Guardian", self.guardian))
        self.outputs = [self.layer.motor(MotorOutput.from_motor(each)) for each in (self.left, self.right)]

    @property
    def log(self) -> list[str]:
        """The entries since the last read of this property."""
        log, self.guardian.log[:] = list(self.guardian.log), []
        return log


def test_lease_begins_before_the_first_command_and_ends_after_the_last_stop() -> None:
    guarded = GuardedMotors()
    left, right = guarded.outputs
    left.set_velocity(1.0)
    right.set_velocity(2.0)
    assert guarded.log == ["driving", "left 1", "driving", "right 2"]
    left.stop()
    assert guarded.log == ["left 0"]
    right.set_velocity(0.0)
    assert guarded.log == ["right 0", "resting"]
    right.stop()
    assert guarded.log == ["right 0"]


def test_lease_continues_if_a_motor_does_not_stop() -> None:
    guarded = GuardedMotors()
    left, _ = guarded.outputs
    left.set_velocity(1.0)
    guarded.left.is_broken = True
    with pytest.raises(DeviceError):
        left.stop()
    assert "resting" not in guarded.log


def test_stop_during_a_command_does_not_end_the_lease() -> None:
    guarded = GuardedMotors()
    left, _ = guarded.outputs
    guarded.left.on_command = lambda rad_s: left.stop() if rad_s else None
    left.set_velocity(1.0)
    assert guarded.log == ["driving"]


def test_dead_guardian_refuses_commands_and_every_motor_stops() -> None:
    guarded = GuardedMotors()
    left, right = guarded.outputs
    left.set_velocity(1.0)
    guarded.guardian.is_dead = True
    with pytest.raises(GuardianError):
        right.set_velocity(1.0)
    assert guarded.log == ["driving", "left 1", "left 0", "right 0"]


def assemble_guarded(guardian: GuardianSpy, rig: Rig) -> CommandFilter:
    guard = GuardianLayer(cast("Guardian", guardian))
    command_filter = assemble(rig.raw, rig.description, rig.rate_hz, guard=guard).command_filter
    assert command_filter
    return command_filter


def test_stop_by_the_guardian_is_an_intervention_and_later_commands_pass() -> None:
    guardian, rig = GuardianSpy(), Rig(description=UNHURRIED)
    command_filter = assemble_guarded(guardian, rig)
    command_filter.ask(Wheels(1.0, 2.0))
    command_filter.commit()
    guardian.reports = [GuardianReply("stop", ("left_motor",), ())]
    command_filter.ask(Wheels(1.0, 2.0))
    (stop,) = command_filter.commit().interventions
    assert (stop.cause, stop.asked, stop.sent) == ("guardian", Wheels(1.0, 2.0), Wheels(0.0, 0.0))
    assert rig.left.received == [1.0, 0.0, 1.0]  # the layer sends the guardian's stop to the motor too
    assert not command_filter.commit().interventions


def test_commit_without_a_command_raises_if_the_guardian_is_dead() -> None:
    guardian, rig = GuardianSpy(), Rig()
    command_filter = assemble_guarded(guardian, rig)
    guardian.is_dead = True
    with pytest.raises(GuardianError):
        command_filter.commit()
    assert rig.wheels == (0.0, 0.0)


def test_robot_without_cutoffs_needs_no_guardian() -> None:
    with ExitStack() as end:
        layer = guard_motors(Robot("bare", SteppedClock(20.0, lambda _: None), []), 0.1, end)
    assert layer is None


def test_guardians_lease_includes_the_longest_patience_of_the_cutoffs(monkeypatch: pytest.MonkeyPatch) -> None:
    leases: list[float] = []

    class LeaseSpy(ExitStack):
        def __init__(self, _: object, lease: float, _priority: int | None) -> None:
            super().__init__()
            leases.append(lease)

    monkeypatch.setattr("robotcore.safety.guardian.client.Guardian", LeaseSpy)
    for patience in ((0.0, 0.0), (0.0, 0.25)):
        cutoffs = [CutoffSpec("motor", "my_board:Stop", {}, each) for each in patience]
        with ExitStack() as end:
            guard_motors(Robot("bare", SteppedClock(20.0, lambda _: None), [], cutoffs=cutoffs), 0.125, end)
    assert leases == pytest.approx([0.125 + LOCK_TIMEOUT_S, 0.125 + LOCK_TIMEOUT_S + 0.25])


def test_acceleration_limit_does_not_use_a_drivers_rounded_velocity() -> None:
    rig = Rig(description=UNHURRIED)
    apply = rig.left.set_velocity
    rig.left.set_velocity = lambda rad_s: round(apply(rad_s))  # type: ignore[method-assign]
    command_filter = assemble_guarded(GuardianSpy(), rig)
    command_filter.ask(Wheels(0.4, 0.4))
    assert command_filter.commit().sent == Wheels(0.4, 0.4)
