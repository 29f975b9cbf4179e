"""The options of `robotcore calibrate` that name the robot, and the robot that they name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import backend_option, merge_options, port_option

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.backend import Backend
    from robotcore.runtime.needs import Need

BENCH = "bench"
"""The world of simulators, without --world."""

_OPTIONS = (
    click.option("--robot", required=True, help="The robot's .toml file, or the name of a robot."),
    click.option("--backend", required=True, help="The robot or simulator. List: `robotcore backends`."),
    click.option("--world", help=f"A world's name, or its .toml file. Default in simulators: {BENCH}."),
    click.option("--seed", type=int, help="The seed of the world's random variations, and of the noise."),
    port_option,
    backend_option,
    click.option("--yes", "is_confirmed", is_flag=True, help="Do not wait for Enter before the robot moves."),
)


def calibrated_robot_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that name the robot to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@dataclass(frozen=True)
class CalibratedSetup:
    """The robot that the options name, and the arguments that open it."""

    description: RobotDescription
    backend: Backend
    is_simulated: bool
    """Whether the backend is a simulator that has the true pose of the robot."""
    arguments: dict[str, Any]
    """The arguments of `open_live_robot`."""

    def list_drive_needs(self) -> frozenset[Need]:
        """Return what turns the robot and measures its turns: the drive with its encoders, and IMUs."""
        from robotcore.hal.robot import Role
        from robotcore.kinds.imu import Imu

        return frozenset({Role.DRIVE, Imu})


def load_calibrated_robot(
    robot: str,
    backend: str,
    world: str | None,
    seed: int | None,
    options: tuple[tuple[str, str], ...],
    port: str | None,
) -> CalibratedSetup:
    """Return the robot that the options name. Raises the errors of loading a robot and a backend."""
    from robotcore.hal.backend import Capability, load_backend

    merged = merge_options(options, port=port)
    loaded = load_backend(backend)
    description = loaded.load_robot(robot, merged)
    if world is None and loaded.needs_world:
        world = BENCH
    arguments = {"robot": robot, "backend": backend, "world": world, "seed": seed, "options": merged}
    return CalibratedSetup(description, loaded, Capability.POSE in loaded.capabilities, arguments)


def find_described(description: RobotDescription, kind: str, name: str | None) -> Any:
    """Return the description of a device of a kind: the one with a name, or the first one.

    Raises UsageError if the robot has none, and UnknownNameError if it has none with this name.
    """
    from robotcore.errors import UnknownNameError, UsageError

    words = kind.replace("_", " ")
    found = {device.name: device for device in description.all_of(kind)}
    if not found:
        text = f'{description.source} has no {words}. Add one: [[devices]] with kind = "{kind}"'
        raise UsageError(text, kind=f"no-{words.replace(' ', '-')}")
    if name is not None and name not in found:
        raise UnknownNameError(words, name, list(found))
    return found[name] if name else next(iter(found.values()))
