"""Check what a comparison needs: a simulator, a recording whose wheels turned, and a robot with the same drive."""

from __future__ import annotations

from collections.abc import Sequence

from robotcore.description import RobotDescription
from robotcore.errors import UsageError
from robotcore.fidelity.commands import WheelCommand, find_impossible_command, list_wheel_commands
from robotcore.hal.backend import Backend, Capability, load_backend, loadable_backends
from robotcore.hardware import HardwareBackend
from robotcore.kinds.motor import MotorDescription
from robotcore.recording import Recording, Tick
from robotcore.recording.summary import explain_missing_end
from robotcore.text import pluralize

MAX_DURATION_S = 3600.0
"""The longest part of a recording that is simulated, in seconds."""

MAX_COMMAND_SHARE = 10.0
"""A recorded command is impossible if it is more than this many times the greatest velocity of the recorded motors."""

SCRIPTED = ("mock", "replay")
"""The backends whose sensors do not depend on the commands."""


def load_simulator(name: str) -> Backend:
    """Return the simulator with a name.

    Raises UsageError if the backend is no simulator in lockstep, and BackendMissingError if it is not installed.
    """
    backend = load_backend(name)
    if not _is_simulator(backend):
        known = [each.name for each in loadable_backends() if _is_simulator(each)]
        raise UsageError(
            f"--backend {name}: it is no simulator that can repeat the commands of a recording. Use "
            f"{', '.join(known[:-1])} or {known[-1]}",
            kind="no-simulator",
            backend=name,
            backends=known,
        )
    backend.require_installed()
    return backend


def _is_simulator(backend: Backend) -> bool:
    is_simulated = {Capability.POSE, Capability.LOCKSTEP} <= backend.capabilities and backend.needs_world
    return is_simulated and not isinstance(backend, HardwareBackend)


def choose_ticks(recording: Recording, name: str, duration_s: float | None) -> Sequence[Tick]:
    """Return the ticks to compare.

    name: the name of the recording's file.
    duration_s: the length of the part to compare, in seconds from the first tick; None for all ticks.

    Raises UsageError if they take no time, or too much.
    """
    ticks = recording.ticks
    if ticks and duration_s is not None:
        ticks = [tick for tick in ticks if tick.time - ticks[0].time <= duration_s]
    duration = ticks[-1].time - ticks[0].time if ticks else 0.0
    if duration <= 0:
        reason = explain_missing_end(recording)
        raise UsageError(
            f"{name}: {pluralize(len(ticks), 'tick')} in {duration:g} s are too few to compare"
            f"{f', because {reason}' if reason else ''}. Record a longer run, or compare more of it",
            kind="recording-too-short",
            file=name,
        )
    if duration > MAX_DURATION_S:
        raise UsageError(
            f"{name}: it lasts {duration:.0f} s, and at most {MAX_DURATION_S:g} s are simulated. Compare its "
            "beginning: --duration 60",
            kind="recording-too-long",
            file=name,
            duration_s=duration,
        )
    return ticks


def require_commands(recording: Recording, ticks: Sequence[Tick], name: str) -> list[WheelCommand]:
    """Return the commands to the wheels.

    Raises UsageError if no wheel was commanded to turn, if a command is impossible, or if the sensors do not depend on
    the commands.
    """
    backend = recording.metadata.request.backend
    if backend in SCRIPTED:
        raise UsageError(
            f"{name}: it was recorded on {backend!r}, whose sensors do not depend on the commands. Name the recording "
            "of a robot or a simulator",
            kind="recording-of-a-script",
            file=name,
            backend=backend,
        )
    motors = recording.metadata.description.all_of(MotorDescription)
    fastest = max((each.max_velocity_rad_s for each in motors), default=0.0)
    if impossible := find_impossible_command(ticks, MAX_COMMAND_SHARE * fastest):
        assert impossible.sent
        raise UsageError(
            f"{name}: tick {impossible.number} at {impossible.time:.2f} s sent {impossible.sent.left:.4g} and "
            f"{impossible.sent.right:.4g} rad/s to the wheels, and the recorded motors reach {fastest:g} rad/s. The "
            "recording is damaged. Compare the part before this tick with --duration, or name another recording",
            kind="impossible-command",
            file=name,
            tick=impossible.number,
        )
    commands = list_wheel_commands(ticks)
    if recording.metadata.description.drive is None or not any(any(command.wheels) for command in commands):
        raise UsageError(
            f"{name}: no wheel of a drive was commanded to turn. Record a run that drives",
            kind="recording-without-motion",
            file=name,
        )
    return commands


def require_same_drive(recorded: RobotDescription, robot: RobotDescription) -> None:
    """Raise UsageError if a robot has no drive of the same kind as the recorded one."""
    if recorded.drive and (robot.drive is None or robot.drive.kind != recorded.drive.kind):
        drive = f"a drive of the kind {robot.drive.kind!r}" if robot.drive else "no drive"
        raise UsageError(
            f"--robot {robot.file or robot.name}: it has {drive}, but that of the recorded robot {recorded.name!r} has "
            f"the kind {recorded.drive.kind!r}. Name a file of the recorded robot",
            kind="other-drive",
            robot=robot.name,
        )
