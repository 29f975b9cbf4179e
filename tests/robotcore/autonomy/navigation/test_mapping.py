from __future__ import annotations

import math

import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.mapping import HISTORY_S, LATELY, Map, MapMemory, PoseHistory, RangeIntegrator
from robotcore.autonomy.navigation.next_best_view import Coverage
from robotcore.geometry import Pose
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Frame
from tests.robotcore.autonomy.navigation.places import HERE, REACH
from tests.robotcore.fakes import NullRange, Rig, picture


@pytest.fixture
def past() -> PoseHistory:
    past = PoseHistory()
    for tick in range(100):
        past.note(tick / 20, Pose(tick / 100, 0.0, tick / 10))
    return past


def test_between_two_poses_it_is_on_the_straight_line(past: PoseHistory) -> None:
    assert past.at(4.0 + 0.0125) == pytest.approx((0.8025, 0.0, 8.025))


def test_a_pose_that_was_noted_is_given_back_to_the_bit(past: PoseHistory) -> None:
    assert past.at(99 / 20) == Pose(99 / 100, 0.0, 99 / 10)
    assert past.at(80 / 20) == Pose(80 / 100, 0.0, 80 / 10)


def test_beyond_what_is_known_it_is_the_nearest(past: PoseHistory) -> None:
    assert past.at(100.0).heading == 9.9
    assert past.at(0.0) == past.at(99 / 20 - HISTORY_S)


TICK_RAD = 0.07
"""What the robot turns from one reading to the next."""


class Ear:
    """A range sensor at the origin with a cone of 0.5 rad, and the memory that it fills."""

    def __init__(self) -> None:
        grid = OccupancyGrid()
        self.memory = MapMemory(grid, Coverage(grid))
        self.grid = grid
        self._hearing = RangeIntegrator(self.memory)
        self._nose = NullRange(SteppedClock(20, lambda _: None))

    def hear(self, *distances: float, heading: float = 0.0, turning: float = 0.0) -> list[bool]:
        """Take in readings, one after the other, and return which of them made the memory forget."""
        forgot = []
        for index, distance in enumerate(distances):
            pose = Pose(0.0, 0.0, heading + turning * index)
            self.memory.move(pose)
            forgot.append(self._hearing.hear(self._nose, distance, pose))
        return forgot

    def is_taken(self, x: float, y: float = 0.0) -> bool:
        return bool(self.grid.taken[self.grid.cell_of(x, y)])

    def is_free(self, x: float, y: float = 0.0) -> bool:
        return bool(self.grid.free[self.grid.cell_of(x, y)])


@pytest.fixture
def ear() -> Ear:
    return Ear()


@pytest.mark.parametrize("lone", [1.8, 1.2, 0.3, math.inf])
def test_a_reading_that_those_before_and_after_contradict_leaves_nothing(ear: Ear, lone: float) -> None:
    other = Ear()
    assert not any(ear.hear(0.8, 0.8, lone, 0.81, 0.8))
    other.hear(0.8, 0.8, 0.81, 0.8)
    assert (ear.grid.evidence == other.grid.evidence).all()
    assert (ear.grid.heard_from == other.grid.heard_from).all()
    assert ear.is_taken(0.8)


def test_what_was_seen_through_a_wall_that_a_false_echo_took_away_was_not_looked_at(ear: Ear) -> None:
    ear.grid.add_free_disc(0.0, 0.0, 0.2, 0.1)
    ear.hear(0.8, 1.8)
    ear.memory.coverage.add_view(HERE, 0.4)
    assert ear.memory.coverage.looked_at[ear.grid.cell_of(1.2, 0.0)]
    ear.hear(0.8)
    ear.memory.coverage.add_view(HERE, 0.4)
    looked_at = ear.memory.coverage.looked_at
    assert looked_at[ear.grid.cell_of(0.6, 0.0)]
    assert not looked_at[ear.grid.cell_of(1.2, 0.0)]


def test_a_second_false_echo_is_taken_back_like_the_first(ear: Ear) -> None:
    other = Ear()
    ear.hear(0.8, 1.8, 0.8, 1.8, 0.8)
    other.hear(0.8, 0.8, 0.8)
    assert (ear.grid.evidence == other.grid.evidence).all()


def test_a_reading_that_another_confirms_is_believed_at_once_and_stays(ear: Ear) -> None:
    ear.hear(0.8, 1.8)
    assert ear.is_free(1.2)
    ear.hear(1.8, 0.8)
    assert ear.is_free(1.2)


def test_past_an_edge_the_readings_go_on_and_stay(ear: Ear) -> None:
    ear.hear(0.8, 1.3, 1.9)
    assert ear.is_free(1.5)


def test_a_lone_reading_of_a_cone_that_has_turned_on_is_of_what_only_it_heard(ear: Ear) -> None:
    ear.hear(1.8, 0.5, 1.8, turning=0.3)
    at = 0.5 * math.cos(0.3), 0.5 * math.sin(0.3)
    assert ear.is_taken(*at)


def test_echoes_from_the_midst_of_what_was_free_make_it_forget_what_is_old(ear: Ear) -> None:
    ear.hear(1.8, 1.8, 1.8, heading=1.5)
    ear.hear(1.8, 1.8, 1.8)
    ear.grid.moved += LATELY + 0.1
    ear.hear(1.8, heading=1.5)
    assert ear.hear(1.0, 1.0) == [False, True]
    assert ear.is_taken(1.0)
    assert not ear.is_free(1.4)
    assert ear.is_free(0.03, 0.5)


def test_one_alone_is_no_reason_to_forget(ear: Ear) -> None:
    assert not any(ear.hear(*[1.8] * 5, 1.0, *[1.8] * 5, 0.6, math.inf, 0.6, 1.8))
    assert ear.is_free(1.0)


def test_two_in_a_row_that_are_not_of_one_thing_are_no_reason_either(ear: Ear) -> None:
    assert not any(ear.hear(*[1.8] * 5, 1.0, 0.6, 1.8))


def test_what_has_come_to_stand_in_the_way_is_known_from_the_second_echo_on(ear: Ear) -> None:
    assert ear.hear(*[1.8] * 9, 1.0, 1.0) == [False] * 10 + [True]
    assert ear.is_taken(1.0)
    assert ear.is_free(0.7)


def test_an_echo_of_what_is_known_a_little_off_is_no_surprise(ear: Ear) -> None:
    assert not any(ear.hear(1.0, 1.0, 1.0, 0.95, 0.95, 1.06, 1.06))


def test_a_place_never_heard_of_cannot_be_refuted(ear: Ear) -> None:
    assert not any(ear.hear(1.0, 0.6, 0.6))


def test_a_whole_turn_with_true_odometry_refutes_nothing(ear: Ear) -> None:
    box = [1.0 / max(abs(math.cos(angle)), abs(math.sin(angle))) for angle in (TICK_RAD * i for i in range(270))]
    heard = [min(box[max(i - 3, 0) : i + 4]) for i in range(len(box))]
    assert not any(ear.hear(*heard, turning=TICK_RAD))


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.nose.distance = 1.0
    return rig


@pytest.fixture
def known() -> Map:
    return Map(HERE, REACH)


def test_takes_in_what_is_heard_where_the_robot_stands_and_what_it_looks_at(rig: Rig, known: Map) -> None:
    known.observe(rig.robot, Pose(0.0, 0.01, 0.0))
    ahead = rig.robot.range.mount.x + 1.0
    assert known.grid.taken[known.grid.cell_of(ahead, 0.0)]
    assert known.grid.free[known.grid.cell_of(-0.1, 0.0)]
    assert known.coverage.looked_at[known.grid.cell_of(0.6, 0.0)]
    assert not known.coverage.looked_at[known.grid.cell_of(ahead, 0.0)]


def test_a_reading_that_repeats_the_last_one_is_no_new_evidence(rig: Rig, known: Map) -> None:
    known.observe(rig.robot, HERE)
    once = known.grid.evidence.copy()
    known.observe(rig.robot, Pose(0.0, 0.001, 0.001))
    assert (known.grid.evidence == once).all()


def test_the_same_reading_from_another_heading_is_evidence(rig: Rig, known: Map) -> None:
    known.observe(rig.robot, HERE)
    once = known.grid.evidence.copy()
    known.observe(rig.robot, Pose(0.0, 0.0, 0.1))
    assert (known.grid.evidence != once).any()


def test_a_robot_leaves_its_map_before_it_is_at_the_border(known: Map) -> None:
    assert not known.is_left_at(Pose(5.0, 0.0, 0.0))
    assert known.is_left_at(Pose(0.0, -5.7, 0.0))


def test_a_reading_that_comes_late_is_evidence_from_where_it_was_taken(rig: Rig, known: Map) -> None:
    known.observe(rig.robot, HERE)
    once = known.grid.evidence.copy()
    rig.sleep(0.1)
    rig.nose.age = 0.1
    known.observe(rig.robot, Pose(0.0, 0.0, 1.0))
    assert (known.grid.evidence == once).all()
    rig.sleep(0.1)
    rig.nose.distance = 0.5
    known.observe(rig.robot, Pose(0.0, 0.0, 2.0))
    at = Pose(0.0, 0.0, 1.0).moved(rig.robot.range.mount).to_world(0.5, 0.0)
    assert known.grid.taken[known.grid.cell_of(*at)]


def test_what_a_late_picture_shows_was_looked_at_from_where_it_was_taken(rig: Rig, known: Map) -> None:
    known.observe(rig.robot, HERE)
    rig.eye._newest = lambda: Frame(picture(), 0.0, 0)  # type: ignore[method-assign]
    rig.sleep(0.1)
    behind = Pose(HERE.x, HERE.y, HERE.heading + 3.0)
    known.observe(rig.robot, behind)
    assert not known.coverage.looked_at[known.grid.cell_of(*behind.to_world(0.6, 0.0))]
    rig.eye._newest = lambda: Frame(picture(), 0.1, 1)  # type: ignore[method-assign]
    rig.sleep(0.1)
    known.observe(rig.robot, behind)
    assert known.coverage.looked_at[known.grid.cell_of(*behind.to_world(0.6, 0.0))]
