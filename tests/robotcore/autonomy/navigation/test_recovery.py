from __future__ import annotations

import math

import pytest

from robotcore.autonomy.navigation.recovery import RETREAT_M, BlockageDetector, Retreat
from robotcore.geometry import Pose, Twist

START = Pose(0.0, 0.0, 0.0)
FORWARD, LEFT = Twist(0.2, 0.0), Twist(0.0, 1.0)
TICK_S = 0.05


def count_blockages(command: Twist, moved: Twist, seconds: float, detector: BlockageDetector | None = None) -> int:
    """Command one velocity while the robot moves at another. Return the number of ticks that report a blockage."""
    detector, pose, count = detector or BlockageDetector(), START, 0
    for tick in range(round(seconds / TICK_S)):
        count += detector.observe(tick * TICK_S, pose, command)
        pose = pose.advance(moved.linear * TICK_S, moved.angular * TICK_S)
    return count


class TestBlockageDetector:
    @pytest.mark.parametrize("command", [FORWARD, LEFT, Twist(-0.1, 0.0), Twist(0.2, 0.5)])
    def test_reports_a_robot_that_does_not_move_before_the_safety_rules_do(self, command: Twist) -> None:
        assert count_blockages(command, Twist(0.0, 0.0), seconds=1.4) == 1

    @pytest.mark.parametrize("command", [FORWARD, LEFT, Twist(0.04, 0.0), Twist(0.0, 0.2)])
    def test_does_not_report_a_robot_that_follows_its_command(self, command: Twist) -> None:
        assert count_blockages(command, command, seconds=20.0) == 0

    def test_does_not_report_a_robot_that_stands_as_commanded(self) -> None:
        assert count_blockages(Twist(0.0, 0.0), Twist(0.0, 0.0), seconds=20.0) == 0

    def test_a_rotation_is_no_progress_of_a_robot_that_drives_forward(self) -> None:
        assert count_blockages(FORWARD, LEFT, seconds=1.0) == 1

    def test_leaves_a_robot_that_never_moves_to_the_safety_rules(self) -> None:
        assert count_blockages(FORWARD, Twist(0.0, 0.0), seconds=20.0) == 2

    def test_reports_again_after_progress(self) -> None:
        detector = BlockageDetector()
        assert count_blockages(FORWARD, Twist(0.0, 0.0), 20.0, detector) == 2
        assert count_blockages(FORWARD, FORWARD, 1.0, detector) == 0
        assert count_blockages(FORWARD, Twist(0.0, 0.0), 20.0, detector) == 2

    def test_a_change_of_direction_begins_a_new_comparison(self) -> None:
        detector = BlockageDetector()
        commands = [FORWARD, LEFT] * 40
        assert not any(detector.observe(index * 0.5, START, command) for index, command in enumerate(commands))

    def test_a_pause_of_the_loop_is_no_blockage(self) -> None:
        detector = BlockageDetector()
        assert not detector.observe(0.0, START, FORWARD)
        assert not detector.observe(TICK_S, START, FORWARD)
        assert not detector.observe(60.0, START, FORWARD)


def drive(retreat: Retreat) -> list[Pose]:
    """Follow a retreat to its end with exact motion."""
    poses = [START]
    while (twist := retreat.velocity(poses[-1], turn=1.0)) and len(poses) < 1000:
        poses.append(poses[-1].advance(twist.linear * TICK_S, twist.angular * TICK_S))
    return poses


class TestRetreat:
    def test_drives_back_from_an_obstacle_ahead(self) -> None:
        end = drive(Retreat(START, FORWARD, ahead=0.1))[-1]
        assert end.x == pytest.approx(-RETREAT_M, abs=0.01)
        assert end.heading == 0.0

    def test_drives_forward_from_an_obstacle_behind(self) -> None:
        assert drive(Retreat(START, Twist(-0.1, 0.0), ahead=0.1))[-1].x == pytest.approx(RETREAT_M, abs=0.01)

    @pytest.mark.parametrize("ahead, sense", [(math.inf, 1.0), (0.3, -1.0)])
    def test_turns_back_and_then_drives_where_there_is_room(self, ahead: float, sense: float) -> None:
        end = drive(Retreat(START, LEFT, ahead))[-1]
        assert end.heading == pytest.approx(-0.3, abs=0.06)
        assert math.copysign(1.0, end.x) == sense

    def test_does_not_end_before_the_robot_has_moved(self) -> None:
        retreat = Retreat(START, FORWARD, ahead=0.1)
        assert all(retreat.velocity(START, turn=1.0) for _ in range(1000))
