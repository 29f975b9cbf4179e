"""Devices that are lost during a session, of a robot that waits one second for them (``outage_s = 1.0``)."""

from __future__ import annotations

import pytest

import robotcore
from robotcore import LiveRobot, Routine
from robotcore.errors import DeviceLostError
from tests.robotcore.runtime.test_device_loss import patient as patient  # noqa: PLC0414  a fixture


def list_notes(robot: LiveRobot) -> list[str]:
    assert robot.result
    return robot.result.notes


@pytest.mark.parametrize("target", ["range", "encoders", "connection"])
def test_call_waits_for_a_lost_device(patient: str, target: str) -> None:
    with robotcore.open(patient, world="open", faults=f"{target} lost=0.5 after=1") as robot:
        assert robot.drive.straight(0.4).x == pytest.approx(0.4, abs=0.01)
    (note,) = list_notes(robot)
    assert "was lost once, for 0.5 s in total" in note


@pytest.mark.parametrize("target, device", [("range", "nose"), ("encoders", "left_encoder")])
def test_loss_longer_than_outage_s_ends_the_call_and_the_robot_stays_open(
    patient: str, target: str, device: str
) -> None:
    with robotcore.open(patient, world="open", faults=f"{target} lost=1.5 after=1") as robot:
        with pytest.raises(DeviceLostError) as lost:
            robot.drive.straight(0.4)
        assert lost.value.device == device
        assert robot.clock.now() == pytest.approx(2.0)
        assert robot.ground_truth
        assert robot.ground_truth.is_at_rest
        robot.wait(1.0)
        assert robot.clock.now() == pytest.approx(3.0, abs=0.06)
        before = robot.drive.pose.x
        assert robot.drive.straight(0.1).x - before == pytest.approx(0.1, abs=0.01)


def look(robot: LiveRobot, seconds: float) -> Routine[None]:
    """Read the camera in each tick for a time."""
    end = robot.clock.now() + seconds
    while robot.clock.now() < end:
        robot.camera.read()
        yield
    robot.camera.read()


def test_call_does_not_wait_for_a_device_that_the_call_before_it_has_read(patient: str) -> None:
    with robotcore.open(patient, world="open", faults="camera lost=0.5 after=1.02") as robot:
        robot.run(look(robot, 1.0))
        robot.wait(1.0)
    assert list_notes(robot) == []
    assert robot.clock.now() == pytest.approx(2.0)
