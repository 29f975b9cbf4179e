from __future__ import annotations

from threading import Thread

import pytest

from robotcore.runtime.faults.motors import FaultyMotor
from robotcore.runtime.layers.base import MotorOutput
from robotcore.safety.deadman import LOCK_TIMEOUT_S
from tests.robotcore.fakes import NullMotor
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rig


@pytest.mark.parametrize(
    "spec, turned",
    [
        ("left_motor dead", (0.0, 4.0)),
        ("left_motor weak=0.5", (2.0, 4.0)),
        ("right_motor reversed", (4.0, -4.0)),
        ("drive weak=0.25", (1.0, 1.0)),
    ],
)
def test_motor_gets_another_velocity_than_the_caller_commanded(spec: str, turned: tuple[float, float]) -> None:
    rig = build_rig(spec)
    assert rig.robot.drive.set_wheels(4.0, 4.0) == (4.0, 4.0)
    rig.commit()
    assert rig.wheels == turned


def test_fault_begins_and_ends_during_a_command() -> None:
    rig = build_rig("left_motor dead after=0.05 lasts=0.05")
    rig.robot.drive.set_wheels(4.0, 4.0)
    rig.commit()
    rig.commit()
    rig.sleep(0.02)
    assert rig.left.sent == [4.0, 0.0, 4.0]
    assert rig.right.sent == [4.0]


def test_stopped_motor_gets_no_new_command_when_the_fault_begins() -> None:
    rig = build_rig("left_motor dead lasts=0.1")
    rig.robot.drive.set_wheels(4.0, 4.0)
    rig.commit()
    rig.robot.stop()
    sent = len(rig.left.sent)
    rig.sleep(TICK_S)
    rig.sleep(TICK_S)
    assert rig.left.sent[-1] == 0.0
    assert len(rig.left.sent) == sent


@pytest.mark.parametrize("effect", ["dead", "weak=0.5", "reversed"])
def test_deadman_stops_a_faulty_motor(effect: str) -> None:
    rig = build_rig(f"drive {effect}")
    rig.robot.drive.set_wheels(4.0, 4.0)
    rig.commit()
    rig.sleep(0.2)
    assert rig.wheels == (0.0, 0.0)


@pytest.mark.parametrize(
    "call_s, received", [(None, [4.0, 2.0, 0.0, 0.0]), (LOCK_TIMEOUT_S / 2, [4.0, 2.0, 0.0])], ids=["hangs", "returns"]
)
def test_stop_from_another_thread_wins_over_a_renewed_command(call_s: float | None, received: list[float]) -> None:
    """A deadman on a real clock stops from a thread of its own. During a call that hangs it does not wait."""
    motor, gains = NullMotor("left_motor"), iter((1.0, 0.5, 0.5))
    weak = FaultyMotor(MotorOutput.of(motor), lambda: next(gains))
    weak.set_velocity(4.0)
    stopping = Thread(target=weak.stop)

    def stop_meanwhile(rad_s: float) -> None:
        if rad_s == 2.0:
            stopping.start()
            stopping.join(call_s)

    motor.on_command = stop_meanwhile
    weak.renew()
    stopping.join()
    assert motor.received == received
    assert motor.sent[-1] == 0.0
