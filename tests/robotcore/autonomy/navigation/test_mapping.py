from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.mapping import Map
from robotcore.geometry import Pose
from robotcore.hal.devices import Frame
from tests.robotcore.autonomy.navigation.places import HERE, REACH
from tests.robotcore.fakes import Rig, picture


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
