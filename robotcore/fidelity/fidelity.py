"""Compare a recorded run with simulations of it, one by the robot's recorded description and one by a robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

from robotcore.description import Floor, RobotDescription, Start, WorldDescription
from robotcore.errors import UsageError
from robotcore.fidelity.commands import WheelCommand, list_servo_commands
from robotcore.fidelity.inputs import choose_ticks, load_simulator, require_commands, require_same_drive
from robotcore.fidelity.measures import Differences, PathDifference, compare
from robotcore.fidelity.motor_conversion import MotorConversion, build_conversions
from robotcore.fidelity.notes import (
    describe_left_out,
    describe_motors,
    describe_other_robot,
    describe_path,
    describe_recording,
    describe_world,
    get_title,
)
from robotcore.fidelity.recorded_data import RecordedData, read_recorded
from robotcore.fidelity.run_data import RunData, list_ray_sensors
from robotcore.fidelity.simulated_run import SimulationInputs, simulate
from robotcore.geometry import Pose, wrap_angle
from robotcore.kinds.encoder import EncoderDescription
from robotcore.recording import Recording, Tick
from robotcore.recording.summary import is_plausible
from robotcore.text import pluralize

__all__ = ["Fidelity", "SimulationResult", "measure_fidelity"]

AS_RECORDED = "as recorded"
"""The title of the simulation with the recorded description."""

FLOOR_SIDE_M = 10.0
"""The side of the floor without a world, in metres. The ground beyond it is the same."""

MAX_UNKNOWN_S = 0.5
"""A path is incomplete if its end is unknown for more than this time, in seconds."""

FARTHEST_M = 100.0
"""The greatest coordinate of a start in a world, in metres."""


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """A simulation of the recorded run, and its differences from it.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.fidelity.fidelity import measure_fidelity
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     fidelity = measure_fidelity(read(Path(folder, "run.mcap")), "run.mcap")
    >>> (simulation,) = fidelity.simulations
    >>> simulation.title, simulation.robot.name
    ('as recorded', 'rover')
    """

    title: str
    """`AS_RECORDED`, or the name of the robot's file."""
    robot: RobotDescription
    run: RunData
    differences: Differences
    conversions: Mapping[str, MotorConversion]
    """The conversions of the recorded commands, by the names of the motors."""
    missing: frozenset[str] = frozenset()
    """The cameras that the simulator could not open."""


@dataclass(frozen=True, eq=False)
class Fidelity:
    """A recorded run, its simulations, and their differences.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.fidelity.fidelity import measure_fidelity
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     fidelity = measure_fidelity(read(Path(folder, "run.mcap")), "run.mcap")
    >>> fidelity.backend, fidelity.duration_s, fidelity.measures["path.end_m"]
    ('kinematic', 0.5, 0.0)
    """

    name: str
    """The name of the recording's file."""
    recording: Recording
    backend: str
    """The name of the simulator."""
    world: WorldDescription | None
    """The simulated world; None for an empty floor."""
    recorded: RecordedData
    commands: Sequence[WheelCommand]
    """The recorded commands to the wheels."""
    simulations: tuple[SimulationResult, ...]
    """The simulation with the recorded description, and the one with a robot's file if there is one."""
    notes: tuple[str, ...]
    """Sentences about the sources of the measures, and about what the simulation does not have."""

    @property
    def encoder_step_rad(self) -> float:
        """The angle of one count of the recorded robot's encoders, in radians; 0 without encoders."""
        return _find_encoder_step(self.recording.metadata.description)

    @property
    def duration_s(self) -> float:
        """The duration of the compared part of the recording, in seconds."""
        return float(self.recorded.run.times[-1])

    @cached_property
    def measures(self) -> dict[str, float]:
        """The measures of the last simulation by their dotted JSON keys, such as ``path.end_m``.

        Those of an incomplete path are NaN.
        """
        differences = self.simulations[-1].differences
        found = dict(_flatten(asdict(differences)))
        if differences.path and _is_incomplete(differences.path, self.duration_s):
            return {key: math.nan if key.startswith("path.") else value for key, value in found.items()}
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields. An unknown value is None.

        The JSON keys:

        file: text; the file of the recording.
        app: text; the recorded app, or its file.
        backend: text; the backend of the recorded run.
        robot: text; the name of the recorded robot.
        simulator: text; the backend that simulates the run.
        world: text or null; the name of the simulated world. Null for an empty floor.
        duration_s: number, s; the duration of the compared part.
        ticks: whole number; the number of compared ticks.
        path_source: text; the source of the recorded path.
        as_recorded: object; the differences of the simulation with the recorded robot.
        as_recorded.*: robotcore.fidelity.measures.Differences
        with_robot: object or null; the same keys, for the robot of ``--robot``. Null without ``--robot``.
        notes: list of text; sentences about the sources of the measures, and about what the simulation lacks.
        """
        request, differences = self.recording.metadata.request, [asdict(each.differences) for each in self.simulations]
        return {
            "file": self.name,
            "app": request.app_reference,
            "backend": request.backend,
            "robot": self.recording.metadata.description.name,
            "simulator": self.backend,
            "world": self.world.name if self.world else None,
            "duration_s": self.duration_s,
            "ticks": len(self.recorded.run.times),
            "path_source": self.recorded.source.value,
            "as_recorded": differences[0],
            "with_robot": differences[1] if len(differences) > 1 else None,
            "notes": list(self.notes),
        }


def _is_incomplete(path: PathDifference, duration_s: float) -> bool:
    return duration_s - path.known_s > MAX_UNKNOWN_S


def _flatten(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{key}.")
        elif value is not None:
            yield f"{prefix}{key}", value


def measure_fidelity(
    recording: Recording,
    name: str,
    backend: str = "kinematic",
    *,
    robot: RobotDescription | None = None,
    world: WorldDescription | None = None,
    duration_s: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> Fidelity:
    """Repeat the commands of a recorded run in a simulator, and return how much the two runs differ.

    name: the name of the recording's file, for messages.
    backend: the name of the simulator.
    robot: another description of the robot, for a second simulation; None for the recorded description only.
    world: the world of the simulation; None for the recorded world, or for an empty floor if none was recorded.
    duration_s: the length of the part to compare, in seconds from the first tick; None for the whole recording.
    options: the options of the simulator.

    Raises UsageError if the recording has no commands to wheels, the backend is no simulator, or the robot has another
    drive. Raises DeviceError or BackendError if the simulator fails.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=2.0), [recorder], [recorder.layer])
    ...     fidelity = measure_fidelity(read(Path(folder, "run.mcap")), "run.mcap")
    >>> fidelity.simulations[0].differences.path.end_m
    0.0
    """
    simulator, recorded = load_simulator(backend), recording.metadata.description
    ticks = choose_ticks(recording, name, duration_s)
    commands = require_commands(recording, ticks, name)
    if robot:
        require_same_drive(recorded, robot)
        robot = robot.idealise() if recording.metadata.request.ideal else robot
    room = world or recording.metadata.world
    measured = read_recorded(recording, ticks, robot or recorded, _find_odometry_start(room, ticks))
    simulations = []
    for title, described in ((AS_RECORDED, recorded), *([(get_title(robot), robot)] if robot else [])):
        inputs = _build_inputs(recording, ticks, commands, measured.run, described, room, options or {})
        done = simulate(simulator, inputs)
        differences = compare(measured.run, done.data, commands, _find_encoder_step(recorded))
        simulations.append(SimulationResult(title, described, done.data, differences, inputs.conversions, done.missing))
    notes = tuple(_list_notes(recording, ticks, measured, simulations, room, robot))
    return Fidelity(name, recording, backend, room, measured, commands, tuple(simulations), notes)


def _find_odometry_start(world: WorldDescription | None, ticks: Sequence[Tick]) -> Pose:
    """Return the pose in the world at which the odometry of these ticks begins."""
    start, first = world.start.pose if world else Pose(0.0, 0.0, 0.0), ticks[0].pose
    return start.compose(first) if first and is_plausible(first) else start


def _build_inputs(
    recording: Recording,
    ticks: Sequence[Tick],
    commands: Sequence[WheelCommand],
    recorded: RunData,
    robot: RobotDescription,
    world: WorldDescription | None,
    options: Mapping[str, Any],
) -> SimulationInputs:
    metadata = recording.metadata
    room = world or WorldDescription(name="floor", floor=Floor(length_m=FLOOR_SIDE_M, width_m=FLOOR_SIDE_M))
    return SimulationInputs(
        recorded=metadata.description,
        robot=robot.with_conditions(room.conditions),
        world=room.model_copy(update={"start": _place_start(recorded.start or room.start.pose)}),
        times=recorded.times.tolist(),
        wheel_commands=commands,
        servo_commands=list_servo_commands(ticks, frozenset(servo.name for servo in robot.all_of("servo"))),
        conversions=build_conversions(metadata.request.backend, metadata.description, robot),
        reads=_list_reads(recorded, robot) if world else {},
        rate_hz=metadata.request.rate_hz,
        seed=metadata.request.seed or 0,
        options=options,
    )


def _place_start(pose: Pose) -> Start:
    if max(abs(pose.x), abs(pose.y)) > FARTHEST_M:
        raise UsageError(
            f"the recorded run begins at x = {pose.x:g} m, y = {pose.y:g} m, more than {FARTHEST_M:g} m from the "
            "middle of the world. Name the recording of another run",
            kind="start-too-far",
        )
    return Start(x_m=pose.x, y_m=pose.y, yaw_rad=wrap_angle(pose.heading))


def _list_reads(recorded: RunData, robot: RobotDescription) -> dict[int, list[str]]:
    """Return the sensors to read in each tick: those with rays as in the run, and cameras for the pictures."""
    known = {*list_ray_sensors(robot), *(camera.name for camera in robot.all_of("camera"))}
    ticks: dict[str, Iterable[int]] = {name: series.reads for name, series in recorded.ranges.items()}
    ticks |= {name: series.pictures for name, series in recorded.pictures.items()}
    reads: dict[int, list[str]] = {}
    for name, indices in ticks.items():
        for index in indices if name in known else ():
            reads.setdefault(index, []).append(name)
    return reads


def _find_encoder_step(robot: RobotDescription) -> float:
    """Return the angle of a count of the drive's encoders in radians; 0 without encoders."""
    names = robot.drive.encoders if robot.drive else ()
    counts = [each.counts_per_turn for each in robot.all_of(EncoderDescription) if each.name in names]
    return math.tau / min(counts) if counts else 0.0


def _list_notes(
    recording: Recording,
    ticks: Sequence[Tick],
    measured: RecordedData,
    simulations: Sequence[SimulationResult],
    world: WorldDescription | None,
    robot: RobotDescription | None,
) -> Iterator[str]:
    recorded, backend = recording.metadata.description, recording.metadata.request.backend
    yield describe_path(measured.source, robot)
    yield from describe_motors(backend, simulations[-1].conversions)
    yield from describe_world(recording, measured, world)
    yield from describe_recording(recording, ticks)
    yield from describe_left_out(measured)
    path, duration_s = simulations[-1].differences.path, float(measured.run.times[-1])
    if path and _is_incomplete(path, duration_s):
        yield f"the path is known for {path.known_s:.2f} s of {duration_s:.2f} s only, and is compared until then"
    if robot:
        yield from describe_other_robot(recorded, robot, measured)
    if missing := sorted(simulations[0].missing):
        yield f"the simulator draws no pictures on this machine, so those of {', '.join(missing)} are left out"
    for simulation in simulations:
        contacts = simulation.run.contacts
        if contacts and contacts != measured.run.contacts:
            known = "an unknown number" if measured.run.contacts is None else measured.run.contacts
            yield f"{simulation.title}: {pluralize(contacts, 'contact')} with obstacles, recorded: {known}"
