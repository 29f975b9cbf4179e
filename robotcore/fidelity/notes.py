"""Sentences about a comparison of a recorded run with its simulations: its sources, and what they do not have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from robotcore.description import RobotDescription, WorldDescription
from robotcore.fidelity.motor_conversion import MotorConversion, load_hardware
from robotcore.fidelity.recorded_data import PathSource, RecordedData
from robotcore.recording import Recording, Tick
from robotcore.recording.run_comparison import build_room
from robotcore.recording.summary import explain_missing_end
from robotcore.text import pluralize

MAX_MESSAGE = 120
"""The maximum number of characters of a recorded error in a sentence."""


def get_title(robot: RobotDescription) -> str:
    """Return the file of a robot, or the name of a shipped robot."""
    return robot.file or robot.name


def describe_recording(recording: Recording, ticks: Sequence[Tick]) -> Iterator[str]:
    """Yield sentences about the begin, the end and the faults of a recorded run."""
    if ticks[0].number and ticks[0].time > 0:
        yield f"the recording begins at {ticks[0].time:.1f} s of its run; the simulated wheels begin at rest"
    if explanation := explain_missing_end(recording):
        yield explanation
    if faults := recording.metadata.request.faults:
        yield f"the recorded run had injected faults, and the simulation has none: {'; '.join(faults)}"
    if failed := next((tick for tick in ticks if tick.error), None):
        assert failed.error
        text = failed.error.message[:MAX_MESSAGE]
        yield f"an error stopped the wheels at {failed.time:.1f} s, in the simulation too: {text}"


def describe_left_out(measured: RecordedData) -> Iterator[str]:
    """Yield sentences about the impossible samples and poses of a recording."""
    if measured.lost_poses:
        yield f"{pluralize(measured.lost_poses, 'impossible true pose')} left out"
    for name, count in measured.left_out.items():
        yield f"{pluralize(count, 'impossible sample')} of {name} left out"


def describe_path(source: PathSource, robot: RobotDescription | None) -> str:
    """Return a sentence about the source of the recorded path.

    robot: the description in a file; None without one.
    """
    if source is PathSource.TRUTH:
        return "the recorded path is the true path of a simulator"
    if source is PathSource.NONE:
        return "the recorded path is unknown, because neither a simulator nor encoders measured it"
    wheels = (
        f"the wheels of {get_title(robot)}" if robot else "the recorded wheels, so an error of their size has no effect"
    )
    return f"the recorded path is computed by odometry, with {wheels}"


def describe_motors(backend: str, conversions: Mapping[str, MotorConversion]) -> Iterator[str]:
    """Yield a sentence about the velocities of the wheels.

    backend: the backend of the recorded run.
    conversions: the conversions of the commands to the motors.
    """
    if any(conversion.models for conversion in conversions.values()):
        yield "the wheels turn by the models of their motors, at the duties that were sent"
    elif load_hardware(backend):
        yield "the wheels turn as commanded, because no motor has a model in both descriptions and no control"


def describe_world(recording: Recording, measured: RecordedData, world: WorldDescription | None) -> Iterator[str]:
    """Yield sentences about the simulated world."""
    recorded = recording.metadata.world
    if world is None:
        if measured.run.ranges or measured.run.pictures:
            yield "no world is known, so the floor is empty, and ranges and pictures are left out: --world FILE"
    elif load_hardware(recording.metadata.request.backend) and measured.source is not PathSource.TRUTH:
        yield f"ranges and pictures also differ if the real room differs from {world.name}"
    elif recorded and build_room(recorded) != build_room(world):
        yield f"ranges and pictures also differ because {world.name} is not the recorded world {recorded.name}"


def describe_other_robot(recorded: RobotDescription, robot: RobotDescription, measured: RecordedData) -> Iterator[str]:
    """Yield sentences about the differences of a robot's file from the recorded robot."""
    if robot.name != recorded.name:
        yield f"{get_title(robot)} describes the robot {robot.name}, and {recorded.name} was recorded"
    kinds = {each.name: each.kind for each in robot.devices}
    compared = {each.name: each.kind for each in recorded.devices if each.name in measured.run.sensors}
    if missing := [name for name, kind in compared.items() if kinds.get(name) != kind]:
        verb = "is" if len(missing) == 1 else "are"
        yield f"{get_title(robot)} has no device {', '.join(missing)}, which {verb} left out"
    if measured.run.angles and robot.drive and not robot.drive.encoders:
        yield f"{get_title(robot)} has no encoders, so the speeds of its wheels are left out"
