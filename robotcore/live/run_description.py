"""The description of a run for its page, and the pictures of its world and its map."""

from __future__ import annotations

from typing import Any

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.description import DeviceDescription, RobotDescription, WorldDescription
from robotcore.hal.backend import Capability, load_backend
from robotcore.hal.device import Sensor, list_values
from robotcore.hal.kind import load_kind
from robotcore.live.messages import to_json
from robotcore.optics import Image
from robotcore.runtime.apps import app_name
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.observer import RunContext
from robotcore.view.overhead import MapTransform, draw_map

PICTURE_PX = 900
"""The width and the height of the picture of the world, in pixels."""

MAP_PX = 600
"""The greatest width and height of the picture of the app's map, in pixels."""


def describe_run(run: RunContext) -> dict[str, Any]:
    """Return the message that describes a run: its names, its devices and the limits of its robot."""
    request, description = run.request, run.description
    capabilities = load_backend(request.backend).capabilities
    return {
        "type": "run",
        "app": app_name(request.app_reference),
        "backend": request.backend,
        "robot": description.name,
        "world": run.world.name if run.world else None,
        "seed": request.seed,
        "rate": request.rate_hz,
        "is_simulated": bool({Capability.POSE, Capability.LOCKSTEP} & set(capabilities)),
        "milestones": list(run.behaviour.milestones),
        "faults": [str(fault) for fault in run.faults],
        "devices": [
            describe_device(each, description) for each in description.devices if each.name in run.robot.devices
        ],
        "footprint": [list(corner) for corner in description.body.footprint],
        "bounds": measure_bounds(run.world if run.truth else None),
        "drive": describe_drive(run),
        "can_pace": run.pace is not None,
        "has_operator": run.operator is not None,
        "actuators": list(run.operator.actuators) if run.operator else [],
    }


def describe_device(device: DeviceDescription, robot: RobotDescription) -> dict[str, Any]:
    """Return the name, the kind, the settings and the fields of the samples of a device."""
    kind = load_kind(device.kind)
    settings = device.model_dump(mode="json", exclude={"name", "kind", "mount", "script"})
    values = list_values(kind.sample) if kind.sample else ()
    drive = robot.drive
    sides = {"left": drive.left_motors, "right": drive.right_motors} if drive else {}
    return {
        "name": device.name,
        "kind": device.kind,
        "is_sensor": issubclass(kind.device, Sensor),
        "units": {value.field: value.unit for value in values},
        "settings": to_json(settings),
        "sides": [side for side, motors in sides.items() if device.name in motors],
    }


def describe_drive(run: RunContext) -> dict[str, Any] | None:
    """Return the greatest velocities of the robot; None if it cannot drive."""
    if run.description.drive is None or not run.robot.motors:
        return None
    drive = run.robot.drive
    return {
        "linear": drive.max_linear,
        "angular": drive.max_angular,
        "wheel": drive.max_linear / drive.geometry.wheel_radius,
        "is_measured": bool(run.description.drive.left_encoders),
    }


def measure_bounds(world: WorldDescription | None) -> list[float] | None:
    """Return the edges of the picture of a world: left, bottom, right and top, in metres. None without a world."""
    if world is None:
        return None
    transform = MapTransform.fit(world, [], PICTURE_PX)
    reach = transform.origin[0] / transform.scale
    return [-reach, -reach, reach, reach]


def draw_world(world: WorldDescription | None) -> Image | None:
    """Return the picture of a world from above, without the robot. None without a world."""
    return draw_map(world, [], PICTURE_PX) if world else None


def find_grid(behaviour: Behaviour) -> OccupancyGrid | None:
    """Return the app's map: its attribute ``grid``. None if the app has no such map."""
    grid = getattr(behaviour, "grid", None)
    return grid if isinstance(grid, OccupancyGrid) else None
