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
from robotcore.safety.deadman import LOCK_TIMEOUT_S
from robotcore.safety.guardian.client import Guardian
from robotcore.safety.guardian.protocol import Report
from tests.robotcore.fakes import UNHURRIED, NullMotor, Rig


class Ear:
    """A guardian that keeps what it hears, together with what motors are told."""

    def __init__(self) -> None:
        self.heard: list[str] = []
        self.is_dead = False
        self.made: list[Report] = []

    def renew_lease(self) -> bool:
        self._require_life()
        self.heard.append("driving")
        return True

    def end_lease(self) -> None:
        self.heard.append("resting")

    def stops(self) -> list[Report]:
        self._require_life()
        made, self.made = self.made, []
        return made

    def motor(self, name: str) -> NullMotor:
        motor = NullMotor(name)
        motor.on_command = lambda rad_s: self.heard.append(f"{name} {rad_s:g}")
        return motor

    def _require_life(self) -> None:
        if self.is_dead:
            raise GuardianError("dead")


class Guarded:
    """Two motors on their own under the layer."""

    def __init__(self) -> None:
        self.guardian = Ear()
        self.left, self.right = self.guardian.motor("left"), self.guardian.motor("right")
        self.layer = GuardianLayer(cast("Guardian", self.guardian))
        self.over = [self.layer.motor(MotorOutput.of(each)) for each in (self.left, self.right)]

    @property
    def heard(self) -> list[str]:
        heard, self.guardian.heard[:] = list(self.guardian.heard), []
        return heard


def test_a_lease_begins_before_the_motor_turns_and_ends_when_the_last_one_was_reported_to_stand() -> None:
    guard_motors = Guarded()
    left, right = guard_motors.over
    left.set_velocity(1.0)
    right.set_velocity(2.0)
    assert guard_motors.heard == ["driving", "left 1", "driving", "right 2"]
    left.stop()
    assert guard_motors.heard == ["left 0"]
    right.set_velocity(0.0)
    assert guard_motors.heard == ["right 0", "resting"]
    right.stop()
    assert guard_motors.heard == ["right 0"]


def test_a_motor_that_does_not_stop_is_guarded_on() -> None:
    guard_motors = Guarded()
    left, _ = guard_motors.over
    left.set_velocity(1.0)
    guard_motors.left.is_broken = True
    with pytest.raises(DeviceError):
        left.stop()
    assert "resting" not in guard_motors.heard


def test_a_command_that_failed_may_have_come_through() -> None:
    guard_motors = Guarded()
    left, _ = guard_motors.over
    guard_motors.left.is_broken = True
    with pytest.raises(DeviceError):
        left.set_velocity(1.0)
    guard_motors.left.is_broken = False
    assert guard_motors.heard == ["driving", "left 1"]
    left.stop()
    assert guard_motors.heard == ["left 0", "resting"]


def test_a_stop_in_the_middle_of_a_command_does_not_end_its_lease() -> None:
    guard_motors = Guarded()
    left, _ = guard_motors.over
    guard_motors.left.on_command = lambda rad_s: left.stop() if rad_s else None
    left.set_velocity(1.0)
    assert guard_motors.heard == ["driving"]


def test_without_a_guardian_no_motor_is_reported_to_turn_and_all_are_stopped() -> None:
    guard_motors = Guarded()
    left, right = guard_motors.over
    left.set_velocity(1.0)
    guard_motors.guardian.is_dead = True
    with pytest.raises(GuardianError):
        right.set_velocity(1.0)
    assert guard_motors.heard == ["driving", "left 1", "left 0", "right 0"]


def test_a_stop_of_the_guardian_is_an_intervention_and_driving_goes_on() -> None:
    guardian, rig = Ear(), Rig(description=UNHURRIED)
    guard = GuardianLayer(cast("Guardian", guardian))
    assembled = assemble(rig.raw, rig.description, rig.rate_hz, guard=guard)
    assert assembled.stage
    assembled.stage.ask(Wheels(1.0, 2.0))
    assembled.stage.commit()
    guardian.made = [Report("stop", ("left_motor",), ())]
    assembled.stage.ask(Wheels(1.0, 2.0))
    commit = assembled.stage.commit()
    (intervention,) = commit.interventions
    assert (intervention.cause, intervention.asked, intervention.sent) == (
        "guardian",
        Wheels(1.0, 2.0),
        Wheels(0.0, 0.0),
    )
    assert rig.left.received == [1.0, 0.0, 1.0]  # the driver hears of the stop too
    assert not assembled.stage.commit().interventions


def test_a_tick_without_a_command_ends_a_run_whose_guardian_has_died() -> None:
    guardian, rig = Ear(), Rig()
    guard = GuardianLayer(cast("Guardian", guardian))
    assembled = assemble(rig.raw, rig.description, rig.rate_hz, guard=guard)
    assert assembled.stage
    guardian.is_dead = True
    with pytest.raises(GuardianError):
        assembled.stage.commit()
    assert rig.wheels == (0.0, 0.0)


def test_a_robot_without_cutoffs_needs_no_guardian() -> None:
    with ExitStack() as end:
        layer = guard_motors(Robot("bare", SteppedClock(20.0, lambda _: None), []), 0.1, end)
    assert layer is None


def test_the_guardian_waits_as_long_as_the_most_patient_cutoff_asks_for(monkeypatch: pytest.MonkeyPatch) -> None:
    leases: list[float] = []

    class Noted(ExitStack):
        def __init__(self, _: object, lease: float) -> None:
            super().__init__()
            leases.append(lease)

    monkeypatch.setattr("robotcore.safety.guardian.client.Guardian", Noted)
    for patience in ((0.0, 0.0), (0.0, 0.25)):
        cutoffs = [CutoffSpec("motor", "my_board:Stop", {}, each) for each in patience]
        with ExitStack() as end:
            guard_motors(Robot("bare", SteppedClock(20.0, lambda _: None), [], cutoffs=cutoffs), 0.125, end)
    assert leases == pytest.approx([0.125 + LOCK_TIMEOUT_S, 0.125 + LOCK_TIMEOUT_S + 0.25])


def test_a_driver_that_rounds_does_not_hold_back_the_acceleration_limit() -> None:
    rig = Rig(description=UNHURRIED)
    apply = rig.left.set_velocity
    rig.left.set_velocity = lambda rad_s: round(apply(rad_s))  # type: ignore[method-assign]
    guardian = Ear()
    guard = GuardianLayer(cast("Guardian", guardian))
    assembled = assemble(rig.raw, rig.description, rig.rate_hz, guard=guard)
    assert assembled.stage
    assembled.stage.ask(Wheels(0.4, 0.4))
    assert assembled.stage.commit().sent == Wheels(0.4, 0.4)
