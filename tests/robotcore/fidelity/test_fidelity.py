"""A recorded run and its simulations with the same commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.description import RobotDescription, load_robot, load_world
from robotcore.errors import DescriptionError, UsageError
from robotcore.fidelity.bounds import Bound, list_missed_bounds
from robotcore.fidelity.fidelity import Fidelity, measure_fidelity
from robotcore.fidelity.measures import Differences
from robotcore.geometry import Pose, Wheels
from robotcore.recording import GroundTruthSample, RecordedError, Recording, SampleKey
from robotcore.runtime.trace import TickRecord
from tests.robotcore.fidelity.drives import ROVER, record, write_truth
from tests.robotcore.recording.replay.memory import Memory, change_tick, record_run
from tests.robotcore.runs import Watcher
from tests.texts import CheckText, Raises


class Standing(Behaviour):
    """Does not move."""

    needs: ClassVar = {Role.DRIVE}

    def step(self, robot: Robot) -> Status:
        return Status.RUNNING


@pytest.fixture(scope="module")
def recording() -> Recording:
    return record()


@pytest.fixture
def truth(tmp_path: Path) -> str:
    return write_truth(tmp_path / "true.toml")


@pytest.fixture
def real(truth: str) -> Recording:
    """Record a run of a robot whose description is wrong."""
    return record(backend="virtualpi", options={"truth": truth})


def measure(recording: Recording, **others: Any) -> Fidelity:
    return measure_fidelity(recording, "run.mcap", **others)


def without_truth(recording: Recording, **metadata: Any) -> Recording:
    """Return the recording of a real robot."""
    return replace(recording, truth=(), metadata=replace(recording.metadata, **metadata))


def last(fidelity: Fidelity) -> Differences:
    return fidelity.simulations[-1].differences


IMPERFECT = str(Path(__file__).parents[3] / "benchmarks" / "imperfect_rover.toml")


@pytest.mark.parametrize(
    "asked",
    [{}, {"randomise": True}, {"rate_hz": 7.0}, {"ideal": True}, {"robot": IMPERFECT}],
    ids=" ".join,
)
def test_a_run_of_a_simulator_is_repeated_exactly_by_the_same_simulator(asked: dict[str, Any]) -> None:
    found = last(measure(record(**asked)))
    assert found.path
    assert found.path.recorded_m > 0.3
    assert found.path.largest_m == 0.0
    assert [wheel.largest_rad_s for wheel in found.wheels.values()] == [0.0, 0.0]
    assert (found.ranges["nose"].p95_m, found.pictures["eye"].grey_share) == (0.0, 0.0)
    assert found.pictures["eye"].pairs >= 5


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["mujoco", "pybullet"])
def test_a_run_of_a_simulator_with_physics_is_repeated_exactly_too(backend: str) -> None:
    pytest.importorskip(backend)
    found = last(measure(record(backend=backend), backend=backend))
    assert found.path
    assert found.path.recorded_m > 0.3
    assert found.path.largest_m < 1e-9
    assert found.pictures["eye"].grey_share < 1e-6


@pytest.mark.parametrize("robot", ["freenove-4wd", "picar", "scout"])
def test_other_drives_are_repeated_exactly(robot: str) -> None:
    found = last(measure(record(robot=robot, world="open")))
    assert found.path
    assert (found.path.largest_m, found.path.recorded_m > 0.2) == (0.0, True)


def test_the_true_description_of_a_robot_brings_the_simulation_nearer(real: Recording, truth: str) -> None:
    before, after = (each.differences for each in measure(real, robot=load_robot(truth)).simulations)
    assert before.path
    assert after.path
    assert before.path.largest_m > 0.05
    assert after.path.largest_m < 0.003
    for side in ("left", "right"):
        assert after.wheels[side].rms_rad_s < before.wheels[side].rms_rad_s / 5


@pytest.mark.slow
def test_without_truth_the_path_is_that_of_the_odometry_with_the_wheels_of_the_file(
    real: Recording, truth: str, check_text: CheckText
) -> None:
    true_m = last(measure(real)).path.recorded_m  # type: ignore[union-attr]
    before, after = measure(without_truth(real)), measure(without_truth(real), robot=load_robot(truth))
    assert abs(last(before).path.recorded_m - true_m) > 0.015 * true_m  # type: ignore[union-attr]
    assert last(after).path.recorded_m == pytest.approx(true_m, rel=0.005)  # type: ignore[union-attr]
    check_text(before.notes)
    check_text([note.replace(truth, "true.toml") for note in after.notes])


@pytest.mark.slow
def test_another_number_of_encoder_counts_scales_the_recorded_angles(real: Recording, tmp_path: Path) -> None:
    file = tmp_path / "counts.toml"
    file.write_text(ROVER.replace("counts_per_turn = 960", "counts_per_turn = 480"))
    one, two = (measure(without_truth(real), robot=load_robot(name)) for name in ("rover", str(file)))
    assert two.recorded.run.length_m == pytest.approx(2 * one.recorded.run.length_m, rel=0.01)
    assert np.ptp(two.recorded.run.angles["left"].angles) == 2 * np.ptp(one.recorded.run.angles["left"].angles)


def test_a_robot_without_encoders_has_no_measured_path(recording: Recording, check_text: CheckText) -> None:
    devices = tuple(name for name in recording.metadata.devices if "encoder" not in name)
    fidelity = measure(without_truth(recording, devices=devices))
    assert (last(fidelity).path, last(fidelity).wheels) == (None, {})
    assert list(last(fidelity).ranges) == ["nose"]
    check_text(fidelity.notes)


def test_a_replay_without_samples_of_encoders_has_the_angles_of_its_odometry(recording: Recording) -> None:
    samples = {key: each for key, each in recording.samples.items() if "encoder" not in key.device}
    found = measure(replace(recording, samples=samples))
    assert last(found).wheels["left"].largest_rad_s == 0.0


def test_without_a_world_the_floor_is_empty_and_only_wheels_and_path_are_compared(
    recording: Recording, check_text: CheckText
) -> None:
    fidelity = measure(without_truth(recording, world=None))
    assert (last(fidelity).ranges, last(fidelity).pictures) == ({}, {})
    assert last(fidelity).path.largest_m < 0.002  # type: ignore[union-attr]
    check_text(fidelity.notes)
    assert last(measure(without_truth(recording, world=None), world=load_world("arena"))).ranges


def test_a_world_that_differs_from_the_recorded_one_is_noted(recording: Recording, check_text: CheckText) -> None:
    fidelity = measure(recording, world=load_world("open"))
    assert last(fidelity).ranges["nose"].simulated_lost_share == 1.0
    assert last(fidelity).path.largest_m == 0.0  # type: ignore[union-attr]
    check_text(fidelity.notes)


def test_contacts_that_the_recorded_run_did_not_have_are_noted(recording: Recording, check_text: CheckText) -> None:
    world = load_world("arena")
    start = recording.truth[0].pose
    block = world.obstacles[0].model_copy(update={"x_m": start.x + 0.25, "y_m": start.y})
    walled = world.model_copy(update={"obstacles": (block, *world.obstacles[1:])})
    placed = [replace(each, pose=Pose(*start[:2], 0.0)) for each in recording.truth]
    fidelity = measure(replace(recording, truth=placed), world=walled)
    assert fidelity.simulations[0].run.contacts
    check_text(fidelity.notes[-1])


class Person(Watcher):
    """An observer that drives by hand."""

    def tick(self, record: TickRecord) -> None:
        operator = self.calls[0][1].operator
        operator.drive(0.2, 0.5)


@pytest.mark.slow
def test_a_run_that_a_person_drove_by_hand_is_repeated() -> None:
    memory = Memory()
    run(RunRequest(Standing, world="open", has_operator=True, timeout_s=2.0), [memory, Person()], [memory.layer])
    path = last(measure(memory.recording)).path
    assert path
    assert (path.largest_m, path.recorded_m > 0.2) == (0.0, True)


def test_other_names_of_devices_leave_out_their_sensors(
    real: Recording, truth: str, tmp_path: Path, check_text: CheckText
) -> None:
    text = Path(truth).read_text()
    for old, new in (("nose", "sonar"), ("left_motor", "port"), ("right_motor", "starboard"), ('"rover"', '"mine"')):
        text = text.replace(old, new)
    file = tmp_path / "mine.toml"
    file.write_text(text)
    fidelity = measure(real, robot=load_robot(str(file)))
    assert last(fidelity).path.largest_m < 0.003  # type: ignore[union-attr]
    assert list(last(fidelity).ranges) == []
    check_text([note.replace(str(file), "mine.toml") for note in fidelity.notes])


def test_errors_faults_and_a_late_begin_are_noted(recording: Recording, check_text: CheckText) -> None:
    broken = change_tick(recording, 60, error=RecordedError("DeviceError", "left_motor: no current", {}))
    request = replace(recording.metadata.request, faults=("left_motor weak=0.6",))
    ring = replace(
        broken, ticks=broken.ticks[20:], result=None, is_cut=True, metadata=replace(broken.metadata, request=request)
    )
    check_text(measure(ring).notes)


def test_the_beginning_of_a_recording_can_be_compared(recording: Recording) -> None:
    assert measure(recording, duration_s=1.0).duration_s == pytest.approx(1.0)


def with_truth(recording: Recording, change: Callable[[Pose], Pose]) -> Recording:
    truth = [GroundTruthSample(each.tick, each.time, change(each.pose), 0) for each in recording.truth]
    return replace(recording, truth=truth)


def test_poses_that_are_not_finite_do_not_count(recording: Recording) -> None:
    found = measure(with_truth(recording, lambda _: Pose(math.nan, math.inf, 0.0)))
    assert last(found).path.recorded_m < 10  # type: ignore[union-attr]


def test_a_path_ends_where_the_truth_ends_and_meets_no_bound(recording: Recording, check_text: CheckText) -> None:
    truth = [each if each.tick < 20 else replace(each, pose=Pose(math.nan, 0.0, 0.0)) for each in recording.truth]
    found = measure(replace(recording, truth=truth))
    path = last(found).path
    assert path
    assert path.known_s == pytest.approx(0.95)
    check_text(found.notes)
    bounds = [Bound.parse("path.end_m<=9"), Bound.parse("wheels.left.rms_rad_s<=9")]
    check_text(list_missed_bounds(bounds, found.measures))


def with_samples(recording: Recording, keys: Sequence[SampleKey], **changes: float) -> Recording:
    """Return a recording with changes of these samples."""
    changed: dict[SampleKey, Any] = {key: recording.samples[key] for key in keys}
    changed = {key: replace(each, **changes) for key, each in changed.items()}
    return replace(recording, samples={**recording.samples, **changed})


@pytest.mark.parametrize("distance", [math.nan, -5.0, 1e308])
def test_impossible_distances_are_left_out_with_a_note(recording: Recording, distance: float) -> None:
    keys = [key for key in recording.samples if key.device == "nose"]
    found = measure(with_samples(recording, keys[::4], distance=distance))
    assert last(found).ranges["nose"].p95_m == 0.0
    assert "impossible samples of nose left out" in " ".join(found.notes)


@pytest.mark.parametrize("angle", [math.nan, math.inf, 1e308])
def test_impossible_angles_of_encoders_are_left_out_with_a_note(recording: Recording, angle: float) -> None:
    first = next(key for key in recording.samples if key.device == "left_encoder")
    found = measure(with_samples(recording, [first], angle=angle))
    assert last(found).wheels["left"].largest_rad_s < 1.0
    assert "1 impossible sample of left_encoder left out" in found.notes


@pytest.mark.parametrize("sent", [math.nan, math.inf, -1e308, 1e6])
def test_a_recording_with_an_impossible_command_is_refused(recording: Recording, sent: float, raises: Raises) -> None:
    broken = change_tick(recording, 20, sent=Wheels(sent, 0.0))
    with raises(UsageError, "impossible-command", tick=20):
        measure(broken)
    assert measure(broken, duration_s=0.9).duration_s == pytest.approx(0.9)


@pytest.mark.parametrize(
    "change, kind",
    [
        (lambda recording: replace(recording, ticks=recording.ticks[:1]), "recording-too-short"),
        (lambda recording: replace(recording, ticks=()), "recording-too-short"),
        (lambda recording: change_tick(recording, 80, time=1e9), "recording-too-long"),
        (lambda recording: with_truth(recording, lambda pose: Pose(200.0, 0.0, pose.heading)), "start-too-far"),
        (lambda _: record(Standing), "recording-without-motion"),
        (lambda _: record_run("mark-green", robot="lookout", timeout_s=0.2), "recording-without-motion"),
    ],
    ids=["one tick", "no tick", "long", "far", "standing", "no drive"],
)
def test_a_recording_that_cannot_be_compared_is_refused(
    recording: Recording, change: Callable[[Recording], Recording], kind: str, raises: Raises
) -> None:
    with raises(UsageError, kind):
        measure(change(recording))


@pytest.mark.parametrize("backend", ["replay", "mock"])
def test_a_recording_whose_sensors_are_scripted_is_refused(recording: Recording, backend: str, raises: Raises) -> None:
    request = replace(recording.metadata.request, backend=backend)
    with raises(UsageError, "recording-of-a-script", backend=backend):
        measure(replace(recording, metadata=replace(recording.metadata, request=request)))


@pytest.mark.parametrize("backend", ["raspberrypi", "virtualpi", "mock", "vrep"])
def test_a_backend_that_is_no_simulator_is_refused(recording: Recording, backend: str, raises: Raises) -> None:
    with raises(UsageError, "no-simulator", backend=backend):
        measure(recording, backend=backend)


@pytest.mark.parametrize("robot", ["freenove-4wd", "lookout"])
def test_a_robot_with_another_drive_is_refused(recording: Recording, robot: str, raises: Raises) -> None:
    with raises(UsageError, "other-drive", robot=robot):
        measure(recording, robot=load_robot(robot))


def test_a_mistake_in_the_section_of_the_robots_file_is_refused(real: Recording, raises: Raises) -> None:
    tables = load_robot("rover").backends
    robot: RobotDescription = load_robot("rover").model_copy(
        update={"backends": {**tables, "raspberrypi": {**tables["raspberrypi"], "left_motor": {"driver": "h-bridge"}}}}
    )
    with raises(DescriptionError, "missing-key"):
        measure(real, robot=robot)


def test_bounds_hold_for_the_last_column_without_the_sign(real: Recording, truth: str, raises: Raises) -> None:
    fidelity = measure(real, robot=load_robot(truth))
    measures = fidelity.measures
    assert measures["path.largest_m"] == last(fidelity).path.largest_m  # type: ignore[union-attr]
    assert (
        list_missed_bounds(
            [Bound.parse("path.largest_m<=0.003"), Bound.parse("wheels.left.rms_share <= 0.05")], measures
        )
        == []
    )
    assert Bound("path.heading_rad", 0.1).find_problem({"path.heading_rad": -0.2})
    with raises(UsageError, "unknown-measure", name="path.end"):
        Bound.parse("path.end<=1").find_problem({"path.end_m": 0.0})


@pytest.mark.parametrize(
    "text", ["", "path.end_m", "path.end_m>=1", "path.end_m<=", "path.end_m<=nan", "path.end_m<=1e"]
)
def test_other_texts_are_no_bounds(text: str, raises: Raises) -> None:
    with raises(UsageError, "bad-requirement", text=text):
        Bound.parse(text)


@pytest.mark.slow
def test_the_json_has_both_columns(real: Recording, truth: str) -> None:
    one, two = measure(real).to_dict(), measure(real, robot=load_robot(truth)).to_dict()
    assert (one["with_robot"], one["as_recorded"]) == (None, two["as_recorded"])
    assert two["with_robot"] == asdict(last(measure(real, robot=load_robot(truth))))
    assert (one["simulator"], one["path_source"], one["world"]) == ("kinematic", "truth", "arena")
