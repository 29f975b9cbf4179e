from __future__ import annotations

import math

import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.coverage import Coverage
from robotcore.autonomy.navigation.hearing import Hearing
from robotcore.autonomy.navigation.memory import LATELY, Memory
from robotcore.geometry import Pose
from robotcore.hal.clock import SteppedClock
from tests.robotcore.autonomy.navigation.places import HERE
from tests.robotcore.fakes import NullRange

TICK_RAD = 0.07
"""What the robot turns from one reading to the next."""


class Ear:
    """A range sensor at the origin with a cone of 0.5 rad, and the memory that it fills."""

    def __init__(self) -> None:
        grid = OccupancyGrid()
        self.memory = Memory(grid, Coverage(grid))
        self.grid = grid
        self._hearing = Hearing(self.memory)
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
