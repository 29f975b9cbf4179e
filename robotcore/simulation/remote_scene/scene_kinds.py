"""The kinds of devices that a scene can have, and their tables in a section of the robot's file."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field

from robotcore.description import DeviceDescription, RobotDescription, StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.kind import load_kind
from robotcore.kinds.camera import Camera
from robotcore.kinds.display import Display
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.motor import Motor
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.simulation.remote_scene.interface import ObjectKind

Paths = Annotated[
    tuple[Annotated[str, Field(min_length=1)], ...],
    BeforeValidator(lambda paths: (paths,) if isinstance(paths, str) else paths),
    Field(min_length=1, description='a path in quotes, or a list of them: ["/robot/joint", "old_name"]'),
]
"""The possible paths of an object, or its names in scenes without paths. The first one in the scene is used."""


class ObjectBinding(StrictModel):
    """A device's table in a section of the robot's file: the path of its scene object.

    >>> ObjectBinding(path="/rover/nose").path
    ('/rover/nose',)
    """

    path: Paths


class JointBinding(ObjectBinding):
    """The table of a motor or an encoder, which is bound to a joint."""

    reversed: bool = False
    """Whether the joint turns backwards as the robot drives forward."""


class CameraBinding(ObjectBinding):
    """The table of a camera, which is bound to a vision sensor."""

    as_found: bool = False
    """Whether the camera has the resolution and the field of view of the vision sensor.

    If False, the vision sensor must have the resolution and the field of view of the robot's description.
    """


class DisplayBinding(ObjectBinding):
    """The table of a display, which is bound to a vision sensor that shows its pictures."""

    optional: bool = False
    """Whether the scene may lack the vision sensor. The display then keeps its pictures in memory."""


BINDINGS: dict[str, tuple[type[ObjectBinding], ObjectKind]] = {
    Motor.kind: (JointBinding, ObjectKind.JOINT),
    Encoder.kind: (JointBinding, ObjectKind.JOINT),
    RangeSensor.kind: (ObjectBinding, ObjectKind.PROXIMITY_SENSOR),
    Camera.kind: (CameraBinding, ObjectKind.VISION_SENSOR),
    Display.kind: (DisplayBinding, ObjectKind.VISION_SENSOR),
}
"""The model of a device's table and the kind of its scene object, by kind. A scene has no devices of other kinds."""

REMEDY = "Run apps that need it with another --backend"
"""What to do if a robot has a device that no scene has."""


def list_scene_devices(robot: RobotDescription) -> frozenset[str]:
    """Return the names of the devices that a robot can have in a scene."""
    return frozenset(device.name for device in robot.devices if device.kind in BINDINGS)


def require_scene_devices(setup: Setup) -> None:
    """Raise DeviceError if a setup has a device that no scene has."""
    for device in setup.chosen_devices:
        if device.kind not in BINDINGS:
            raise DeviceError(device.name, f"{describe_lack(device)}. {REMEDY}", kind="not-in-scene")


def warn_of_missing_kinds(robot: RobotDescription) -> list[str]:
    """Return a warning for each device that other simulators have, and no scene has."""
    return [f"{device.name}: {describe_lack(device)}. {REMEDY}" for device in find_missing_kinds(robot)]


def find_missing_kinds(robot: RobotDescription) -> list[DeviceDescription]:
    """Return the devices that other simulators have, and no scene has."""
    return [each for each in robot.devices if each.kind not in BINDINGS and load_kind(each.kind).is_simulated]


def describe_lack(device: DeviceDescription) -> str:
    """Return the sentence that a scene has no such device, without a full stop."""
    return f"a scene has no {device.kind.replace('_', ' ')}"
