from __future__ import annotations

import pytest

from tests.robotcore.runtime.faults.rigs import build_rig


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


def test_fault_begins_and_ends_with_the_next_command() -> None:
    rig = build_rig("left_motor dead after=0.05 lasts=0.05")
    for _ in range(3):
        rig.robot.drive.set_wheels(4.0, 4.0)
        rig.commit()
    assert rig.left.sent == [4.0, 0.0, 4.0]


@pytest.mark.parametrize("effect", ["dead", "weak=0.5", "reversed"])
def test_deadman_stops_a_faulty_motor(effect: str) -> None:
    rig = build_rig(f"drive {effect}")
    rig.robot.drive.set_wheels(4.0, 4.0)
    rig.commit()
    rig.sleep(0.2)
    assert rig.wheels == (0.0, 0.0)
