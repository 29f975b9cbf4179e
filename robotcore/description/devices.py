"""The base class of the descriptions of devices, and their mounts on a robot.

The origin of the robot's frame is on the floor under the centre of the axle. In this frame, x points forward, y left
and z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, Union, get_args

from pydantic import Field, GetCoreSchemaHandler

from robotcore.description.types import Coordinate, Name, Radians, StrictModel
from robotcore.errors import BackendMissingError, UsageError
from robotcore.geometry import Pose
from robotcore.plugins import KINDS, kind_names, load_registered

if TYPE_CHECKING:
    from pydantic_core import CoreSchema
    from typing_extensions import Self

AHEAD_RAD = math.pi / 4
"""The greatest angle, in radians, from the robot's x axis to the direction of a sensor that points ahead."""


class Mount(StrictModel):
    """The position and the direction of a device in the robot's frame.

    >>> import math
    >>> mount = Mount(x_m=0.14, z_m=0.10, yaw_rad=0.2)
    >>> mount.pose, mount.is_ahead
    (Pose(x=0.14 m, y=0 m, heading=0.2 rad), True)
    >>> mount.face(math.pi).is_ahead
    False
    """

    x_m: Coordinate = 0.0
    """The distance from the axle forward to the device, in metres."""
    y_m: Coordinate = 0.0
    """The distance of the device to the left of the robot's middle, in metres."""
    z_m: Annotated[float, Field(ge=0, le=100)]
    """The height of the device above the floor, in metres."""
    yaw_rad: Radians = 0.0
    """The angle from the robot's x axis to the device's direction, in radians, positive to the left."""
    pitch_rad: Radians = 0.0
    """The angle from the horizontal to the device's direction, in radians, positive downwards."""
    on: Name | None = None
    """The name of the servo that turns the device about the servo's own mount; None for a device that does not turn.

    The position and the direction of the device are then those at the servo's angle 0.
    """

    def turn(self, angle: float, x_m: float, y_m: float) -> Mount:
        """Return the mount after a turn about a vertical axis.

        angle: the angle in radians, positive to the left.
        x_m, y_m: the position of the axis in the robot's frame, in metres.
        """
        x, y, yaw = Pose(x_m, y_m, angle).compose(Pose(self.x_m - x_m, self.y_m - y_m, self.yaw_rad))
        return self.model_copy(update={"x_m": x, "y_m": y, "yaw_rad": yaw})

    def face(self, yaw_rad: float) -> Mount:
        """Return the mount with another direction, in radians from the robot's x axis."""
        return self.model_copy(update={"yaw_rad": yaw_rad})

    @property
    def is_ahead(self) -> bool:
        """Whether the device's direction is less than 45° from the robot's x axis."""
        return math.cos(self.yaw_rad) * math.cos(self.pitch_rad) > math.cos(AHEAD_RAD)

    @property
    def pose(self) -> Pose:
        """The pose of the device on the robot in the plane."""
        return Pose(self.x_m, self.y_m, self.yaw_rad)


@dataclass(frozen=True)
class Ideal:
    """Marks a key of a device that describes an imperfection. `DeviceDescription.idealise` sets the value.

    >>> from typing import Annotated
    >>> from robotcore.description import DeviceDescription
    >>> class GripperDescription(DeviceDescription):
    ...     play_m: Annotated[float, Ideal(0.0)] = 0.001
    >>> GripperDescription(kind="gripper", name="hand").idealise().play_m
    0.0
    """

    value: Any
    """The value of the key for a device without the imperfection."""


class DeviceDescription(StrictModel):
    """The base class of the descriptions of devices. Each kind of device has a subclass.

    A subclass sets ``kind`` to a literal: the name of its kind in a robot's file.

    >>> from robotcore.kinds.servo import ServoDescription
    >>> pan = ServoDescription(kind="servo", name="pan", min_angle_rad=-1.5, max_angle_rad=1.5, max_velocity_rad_s=5.0)
    >>> pan.kind_name(), pan.arguments()
    ('servo', {'min_angle': -1.5, 'max_angle': 1.5, 'angle': 0.0})
    """

    kind: str
    """The name of the kind, such as ``camera``."""
    name: Name

    @classmethod
    def kind_name(cls) -> str:
        """Return the name of the kind; ``""`` if the field ``kind`` is no literal."""
        return "".join(get_args(cls.model_fields["kind"].annotation)[:1])

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of the device class's constructor, without the name."""
        return {}

    def idealise(self) -> Self:
        """Return the description of the same device without imperfections."""
        fields = type(self).model_fields.items()
        marks = {name: mark for name, field in fields for mark in field.metadata if isinstance(mark, Ideal)}
        return self.model_copy(update={name: mark.value for name, mark in marks.items()})

    def looks_ahead(self, mount: Mount) -> bool:
        """Return whether a sensor with this mount measures the distance ahead of the robot. By default it does not.

        The range guard reads such sensors by `Sensor.measure_ahead`.
        """
        return False

    def find_nearest_ahead(self, mount: Mount, front_x_m: float) -> float:
        """Return the shortest distance ahead, in metres, that a sensor with this mount measures. By default it is 0.

        front_x_m: the x of the robot's front.
        """
        return 0.0

    def configure(self, device: Any) -> None:
        """Set the properties of an open device that the description defines, such as its mount."""
        if isinstance(mount := getattr(self, "mount", None), Mount):
            device.mount = mount.pose


class SensorDescription(DeviceDescription):
    """The base class of the descriptions of sensors whose samples can be late or rare. All simulators simulate both.

    >>> sonar = SensorDescription(kind="sonar", name="nose", latency_s=0.03, rate_hz=10)
    >>> sonar.idealise().latency_s
    0.0
    """

    latency_s: Annotated[float, Field(ge=0, le=10), Ideal(0.0)] = 0.0
    """The time from the measurement of a sample until an app can read it, in seconds.

    A simulator rounds it to its time step.
    """
    rate_hz: Annotated[Annotated[float, Field(ge=0.1, le=1000)] | None, Ideal(None)] = None
    """The number of samples in a second. With None, there is a new sample in each tick."""


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)


def load_model(kind: str) -> type[DeviceDescription]:
    """Return the model of the devices of a registered kind.

    Raises BackendMissingError for a kind that cannot be loaded, and UsageError for a name that two packages register.
    """
    model: object = getattr(load_registered("device kind", KINDS, kind), "description", None)
    if not (isinstance(model, type) and issubclass(model, DeviceDescription) and model.kind_name() == kind):
        raise BackendMissingError(
            f"the entry point of the device kind {kind!r} is not a robotcore.hal.kind.Kind of this name. Correct it",
            name=kind,
        )
    return model


class OfRegisteredKind:
    """Marks a field whose value is the description of a device of any registered kind.

    The schema is built when the first robot is loaded, so that packages can register further kinds. A kind that cannot
    be loaded is left out.
    """

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        models = []
        for name in kind_names():
            with suppress(BackendMissingError, UsageError):
                models.append(load_model(name))
        described: Any = Union[tuple(models)]  # noqa: UP007  the kinds are known only here
        return handler.generate_schema(Annotated[described, Field(discriminator="kind")])


AnyDevice = Annotated[DeviceDescription, OfRegisteredKind]
