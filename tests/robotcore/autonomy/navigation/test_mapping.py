from __future__ import annotations

import math

import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.mapping import (
    DRIFT_LIMIT,
    HISTORY_S,
    MapMemory,
    MissingEchoes,
    NavigationMap,
    PoseHistory,
    RangeIntegrator,
)
from robotcore.autonomy.navigation.next_best_view import Coverage
from robotcore.geometry import Pose
from robotcore.hal.clock import SteppedClock
from robotcore.kinds.camera import Frame
from robotcore.kinds.range_sensor import Range
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH
from tests.robotcore.fakes import NullRange, Rig, picture


@pytest.fixture
def past() -> PoseHistory:
    past = PoseHistory()
    for tick in range(100):
        past.add(tick / 20, Pose(tick / 100, 0.0, tick / 10))
    return past


def test_pose_between_two_is_interpolated(past: PoseHistory) -> None:
    assert past.at(4.0 + 0.0125) == pytest.approx((0.8025, 0.0, 8.025))


def test_pose_outside_the_history_is_the_nearest(past: PoseHistory) -> None:
    assert past.at(100.0).heading == 9.9
    assert past.at(0.0) == past.at(99 / 20 - HISTORY_S)


TICK_RAD = 0.07
"""The turn of the robot between two readings."""


class MappingRig:
    """A range sensor at the origin with a cone of 0.5 rad, and the map from its readings."""

    def __init__(self) -> None:
        grid = OccupancyGrid()
        self.memory = MapMemory(grid, Coverage(grid))
        self.grid = grid
        self._integrator = RangeIntegrator(self.memory)
        self._nose = NullRange(SteppedClock(20, lambda _: None))

    def add(self, *distances: float, heading: float = 0.0, turning: float = 0.0) -> list[bool]:
        """Add readings, and return for each whether the old cells of the map became unknown."""
        forgot = []
        for index, distance in enumerate(distances):
            pose = Pose(0.0, 0.0, heading + turning * index)
            self.memory.move(pose)
            forgot.append(self._integrator.add(self._nose, distance, pose))
        return forgot

    def is_taken(self, x: float, y: float = 0.0) -> bool:
        return bool(self.grid.occupied[self.grid.cell_of(x, y)])

    def is_free(self, x: float, y: float = 0.0) -> bool:
        return bool(self.grid.free[self.grid.cell_of(x, y)])


@pytest.fixture
def mapping() -> MappingRig:
    return MappingRig()


@pytest.mark.parametrize("lone", [1.8, 1.2, 0.3, math.inf])
def test_outlier_between_equal_readings_is_undone(mapping: MappingRig, lone: float) -> None:
    other = MappingRig()
    assert not any(mapping.add(0.8, 0.8, lone, 0.81, 0.8))
    other.add(0.8, 0.8, 0.81, 0.8)
    assert (mapping.grid.evidence == other.grid.evidence).all()
    assert (mapping.grid.nearest_echo == other.grid.nearest_echo).all()
    assert mapping.is_taken(0.8)


def test_view_through_a_wall_that_an_outlier_removed_is_undone(mapping: MappingRig) -> None:
    mapping.grid.add_free_disc(0.0, 0.0, 0.2, 0.1)
    mapping.add(0.8, 1.8)
    mapping.memory.coverage.add_view(HERE, 0.4)
    assert mapping.memory.coverage.seen[mapping.grid.cell_of(1.2, 0.0)]
    mapping.add(0.8)
    mapping.memory.coverage.add_view(HERE, 0.4)
    seen = mapping.memory.coverage.seen
    assert seen[mapping.grid.cell_of(0.6, 0.0)]
    assert not seen[mapping.grid.cell_of(1.2, 0.0)]


def test_jump_that_the_next_reading_confirms_stays(mapping: MappingRig) -> None:
    mapping.add(0.8, 1.8)
    assert mapping.is_free(1.2)
    mapping.add(1.8, 0.8)
    assert mapping.is_free(1.2)


def test_single_reading_of_a_turning_sensor_is_no_outlier(mapping: MappingRig) -> None:
    mapping.add(1.8, 0.5, 1.8, turning=0.3)
    at = 0.5 * math.cos(0.3), 0.5 * math.sin(0.3)
    assert mapping.is_taken(*at)


def test_echoes_from_free_cells_delete_the_old_map(mapping: MappingRig) -> None:
    mapping.add(1.8, 1.8, 1.8, heading=1.5)
    mapping.add(1.8, 1.8, 1.8)
    mapping.grid.travelled += DRIFT_LIMIT + 0.1
    mapping.add(1.8, heading=1.5)
    assert mapping.add(1.0, 1.0) == [False, True]
    assert mapping.is_taken(1.0)
    assert not mapping.is_free(1.4)
    assert mapping.is_free(0.03, 0.5)


def test_one_echo_from_free_cells_deletes_nothing(mapping: MappingRig) -> None:
    assert not any(mapping.add(*[1.8] * 5, 1.0, *[1.8] * 5, 0.6, math.inf, 0.6, 1.8))
    assert mapping.is_free(1.0)


def test_two_echoes_of_different_bodies_delete_nothing(mapping: MappingRig) -> None:
    assert not any(mapping.add(*[1.8] * 5, 1.0, 0.6, 1.8))


def test_new_body_is_mapped_from_its_second_echo(mapping: MappingRig) -> None:
    assert mapping.add(*[1.8] * 9, 1.0, 1.0) == [False] * 10 + [True]
    assert mapping.is_taken(1.0)
    assert mapping.is_free(0.7)


def test_echo_a_little_off_a_mapped_body_deletes_nothing(mapping: MappingRig) -> None:
    assert not any(mapping.add(1.0, 1.0, 1.0, 0.95, 0.95, 1.06, 1.06))


def test_full_turn_with_exact_odometry_deletes_nothing(mapping: MappingRig) -> None:
    box = [1.0 / max(abs(math.cos(angle)), abs(math.sin(angle))) for angle in (TICK_RAD * i for i in range(270))]
    heard = [min(box[max(i - 3, 0) : i + 4]) for i in range(len(box))]
    assert not any(mapping.add(*heard, turning=TICK_RAD))


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.nose.distance = 1.0
    return rig


@pytest.fixture
def new_map() -> NavigationMap:
    return NavigationMap(HERE, REACH)


def test_observe_maps_echo_position_and_view(rig: Rig, new_map: NavigationMap) -> None:
    new_map.observe(rig.robot, Pose(0.0, 0.01, 0.0))
    ahead = rig.robot.range.mount.x + 1.0
    assert new_map.grid.occupied[new_map.grid.cell_of(ahead, 0.0)]
    assert new_map.grid.free[new_map.grid.cell_of(-0.1, 0.0)]
    assert new_map.coverage.seen[new_map.grid.cell_of(0.6, 0.0)]
    assert not new_map.coverage.seen[new_map.grid.cell_of(ahead, 0.0)]


def test_a_reading_that_repeats_the_last_one_is_no_new_evidence(rig: Rig, new_map: NavigationMap) -> None:
    new_map.observe(rig.robot, HERE)
    once = new_map.grid.evidence.copy()
    new_map.observe(rig.robot, Pose(0.0, 0.001, 0.001))
    assert (new_map.grid.evidence == once).all()


def test_the_same_reading_from_another_heading_is_evidence(rig: Rig, new_map: NavigationMap) -> None:
    new_map.observe(rig.robot, HERE)
    once = new_map.grid.evidence.copy()
    new_map.observe(rig.robot, Pose(0.0, 0.0, 0.1))
    assert (new_map.grid.evidence != once).any()


def test_the_same_reading_of_a_turned_sensor_is_mapped_in_its_present_direction(
    rig: Rig, new_map: NavigationMap
) -> None:
    new_map.observe(rig.robot, HERE)
    rig.robot.range.mount = rig.robot.camera.mount = Pose(0.0, 0.0, math.pi / 2)
    new_map.observe(rig.robot, HERE)
    assert new_map.grid.occupied[new_map.grid.cell_of(0.0, 1.0)]
    assert new_map.coverage.seen[new_map.grid.cell_of(0.0, 0.6)]


def test_a_robot_leaves_its_map_before_it_is_at_the_border(new_map: NavigationMap) -> None:
    assert not new_map.is_near_border(Pose(5.0, 0.0, 0.0))
    assert new_map.is_near_border(Pose(0.0, -5.7, 0.0))


def test_late_reading_is_used_with_the_pose_at_its_time(rig: Rig, new_map: NavigationMap) -> None:
    new_map.observe(rig.robot, HERE)
    once = new_map.grid.evidence.copy()
    rig.sleep(0.1)
    rig.nose.age = 0.1
    new_map.observe(rig.robot, Pose(0.0, 0.0, 1.0))
    assert (new_map.grid.evidence == once).all()
    rig.sleep(0.1)
    rig.nose.distance = 0.5
    new_map.observe(rig.robot, Pose(0.0, 0.0, 2.0))
    at = Pose(0.0, 0.0, 1.0).compose(rig.robot.range.mount).to_world(0.5, 0.0)
    assert new_map.grid.occupied[new_map.grid.cell_of(*at)]


def test_late_samples_are_used_with_the_mounts_at_their_time(rig: Rig, new_map: NavigationMap) -> None:
    rig.robot.range.mount = rig.robot.camera.mount = Pose(0.0, 0.0, math.pi / 2)
    new_map.observe(rig.robot, HERE)
    rig.nose.distance, rig.nose.age = 1.5, 0.1
    rig.eye._newest = lambda: Frame(picture(), 0.0, 0)  # type: ignore[method-assign]
    rig.sleep(0.1)
    rig.robot.range.mount = rig.robot.camera.mount = Pose(0.0, 0.0, -math.pi / 2)
    new_map.observe(rig.robot, HERE)
    grid = new_map.grid
    assert grid.occupied[grid.cell_of(0.0, 1.5)]
    assert not grid.occupied[grid.cell_of(0.0, -1.5)]
    assert not new_map.coverage.seen[grid.cell_of(0.0, -0.6)]


def test_late_picture_is_used_with_the_pose_at_its_time(rig: Rig, new_map: NavigationMap) -> None:
    new_map.observe(rig.robot, HERE)
    rig.eye._newest = lambda: Frame(picture(), 0.0, 0)  # type: ignore[method-assign]
    rig.sleep(0.1)
    behind = Pose(HERE.x, HERE.y, HERE.heading + 3.0)
    new_map.observe(rig.robot, behind)
    assert not new_map.coverage.seen[new_map.grid.cell_of(*behind.to_world(0.6, 0.0))]
    rig.eye._newest = lambda: Frame(picture(), 0.1, 1)  # type: ignore[method-assign]
    rig.sleep(0.1)
    new_map.observe(rig.robot, behind)
    assert new_map.coverage.seen[new_map.grid.cell_of(*behind.to_world(0.6, 0.0))]


def test_a_missing_echo_that_may_be_lost_is_no_evidence(rig: Rig, new_map: NavigationMap) -> None:
    rig.robot.range.echo_free_samples = 3
    new_map.observe(rig.robot, HERE)
    once = new_map.grid.evidence.copy()
    rig.nose.distance = math.inf
    for _ in range(2):
        rig.sleep(0.05)
        new_map.observe(rig.robot, HERE)
    assert (new_map.grid.evidence == once).all()
    rig.sleep(0.05)
    new_map.observe(rig.robot, HERE)
    assert new_map.grid.free[new_map.grid.cell_of(1.5, 0.0)]


def test_only_what_all_missing_echoes_have_covered_becomes_free(rig: Rig, new_map: NavigationMap) -> None:
    rig.robot.range.echo_free_samples, rig.nose.distance = 3, math.inf
    for heading in (0.0, 0.1, 0.2):
        new_map.observe(rig.robot, Pose(0.0, 0.0, heading))
        rig.sleep(0.05)
    free = [new_map.grid.free[new_map.grid.cell_of(1.5 * math.cos(at), 1.5 * math.sin(at))] for at in (-0.1, 0.1, 0.3)]
    assert free == [False, True, False]


def test_the_noise_of_the_sensor_counts(rig: Rig, new_map: NavigationMap) -> None:
    rig.robot.range.noise = 0.1
    new_map.observe(rig.robot, HERE)
    ahead = rig.robot.range.mount.x
    free = [new_map.grid.free[new_map.grid.cell_of(ahead + distance, 0.0)] for distance in (0.7, 0.85)]
    assert free == [True, False]


def test_samples_that_a_run_left_out_count_as_missing_echoes() -> None:
    missing = MissingEchoes()
    assert missing.find_start(Range(0.8, 1.0, 10), 3) == 1.0
    assert missing.find_start(Range(math.inf, 1.3, 13), 3) == pytest.approx(1.1)
    assert missing.find_start(Range(math.inf, 1.4, 14), 3) == pytest.approx(1.2)


def test_samples_between_two_ticks_do_not_count_as_missing_echoes() -> None:
    missing = MissingEchoes()
    missing.find_start(Range(0.8, 1.0, 10), 3)
    assert missing.find_start(Range(math.inf, 1.15, 25), 3) == pytest.approx(1.05)
    assert missing.find_start(Range(math.inf, 1.2, 30), 3) == pytest.approx(1.1)


def test_the_first_samples_of_a_run_do_not_show_that_nothing_is_in_range() -> None:
    missing = MissingEchoes()
    readings = [Range(math.inf, at / 10, at) for at in (0, 1, 1, 2, 3)]
    starts = [missing.find_start(reading, 3) for reading in readings]
    assert starts == [None, None, None, pytest.approx(0.0), pytest.approx(0.1)]
