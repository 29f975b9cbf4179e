from __future__ import annotations

import pytest

from robotcore.geometry import Pose
from robotcore.navigation.mapping import Map
from tests.robotcore.fakes import Rig
from tests.robotcore.navigation.places import HERE, REACH


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
