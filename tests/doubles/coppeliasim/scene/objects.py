"""The objects of a scene, and the errors of the real server."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tests.doubles.coppeliasim.scene.poses import ORIGIN, Transform, Vector


class SceneError(Exception):
    """An error in a call of a client. Its text is sent to the client."""


class NoObjectError(SceneError, LookupError):
    """No object has the handle."""

    def __init__(self, what: str = "object does not exist.") -> None:
        super().__init__(what)


Pixels = NDArray[np.uint8]
"""Shape (height, width, 3): red, green, blue; row 0 at the bottom, column 0 on the left."""
Depths = NDArray[np.float32]
"""Shape (height, width): metres along the optical axis; row 0 at the bottom."""


class SensorPicture(Protocol):
    """A picture of a vision sensor, with depths."""

    @property
    def picture(self) -> Pixels: ...
    @property
    def depths(self) -> Depths: ...
    def depths_of_every(self, nth: int) -> Depths: ...


class Type(IntEnum):
    """The values of the API's ``object_..._type``."""

    SHAPE = 0
    JOINT = 1
    CAMERA = 3
    DUMMY = 4
    PROXIMITY_SENSOR = 5
    VISION_SENSOR = 9
    FORCE_SENSOR = 12
    LIGHT = 13
    SCRIPT = 17


class Primitive(IntEnum):
    """The values of the API's ``primitiveshape_...``."""

    CUBOID = 3
    SPHEROID = 4
    CYLINDER = 5


VOLUMES = {Primitive.CUBOID: 1.0, Primitive.SPHEROID: math.pi / 6, Primitive.CYLINDER: math.pi / 4}
"""The volume of each primitive as a fraction of its bounding box."""


class JointMode(IntEnum):
    """The control modes of a dynamic joint: the values of the API's ``jointdynctrl_...``."""

    FREE = 0
    VELOCITY = 4


@dataclass(eq=False)
class Node:
    """An object of a scene.

    local: the pose in the frame of the parent.
    flat_name: the name in V-REP, such as ``bubbleRob_leftMotor``.
    explicit: whether the object is updated only on request (explicit handling).
    parameters: stored parameters that have no effect.
    """

    type = Type.DUMMY

    alias: str
    handle: int = -1
    parent: Node | None = field(default=None, repr=False)
    children: list[Node] = field(default_factory=list, repr=False)
    local: Transform = ORIGIN
    flat_name: str = ""
    is_model_base: bool = False
    explicit: bool = False
    parameters: dict[int, float] = field(default_factory=dict, repr=False)

    @property
    def children_frame(self) -> Transform:
        """The frame of the object's children in the frame of its parent."""
        return self.local


@dataclass(eq=False)
class Dummy(Node):
    """A point with a name."""


@dataclass(eq=False)
class Camera(Node):
    """A camera for the window. The double does not render it."""

    type = Type.CAMERA


@dataclass(eq=False)
class Lamp(Node):
    """A directional lamp along its z axis. A scene has its own light until a client sets a lamp.

    Colours are from 0 to 1.
    """

    type = Type.LIGHT

    is_set: bool = False
    is_on: bool = True
    diffuse: Vector = (0.5, 0.5, 0.5)
    specular: Vector = (0.5, 0.5, 0.5)


@dataclass(eq=False)
class ForceSensor(Node):
    """A force sensor, which is a rigid connection."""

    type = Type.FORCE_SENSOR


@dataclass(eq=False)
class Shape(Node):
    """A primitive shape. ``size`` has the lengths along x, y and z in metres. The ``colour`` is from 0 to 1."""

    type = Type.SHAPE

    primitive: Primitive = Primitive.CUBOID
    size: Vector = (0.1, 0.1, 0.1)
    colour: Vector = (1.0, 1.0, 1.0)
    is_static: bool = True
    is_respondable: bool = False
    mask: int = 0xFFFF
    mass: float = 1.0

    @property
    def volume(self) -> float:
        """The volume in cubic metres."""
        return VOLUMES[self.primitive] * math.prod(self.size)


@dataclass(eq=False)
class Joint(Node):
    """A revolute joint about its z axis, in radians and rad/s.

    lag: the time constant with which a motor follows its target, in seconds.

    The position of a cyclic joint is within half a turn.
    """

    type = Type.JOINT

    is_dynamic: bool = True
    control: int = JointMode.FREE
    position: float = 0.0
    velocity: float = 0.0
    target_velocity: float = 0.0
    target_force: float = 2.5
    is_cyclic: bool = True
    interval: tuple[float, float] = (-math.pi, math.tau)
    lag: float = 0.0

    @property
    def children_frame(self) -> Transform:
        return self.local.compose(Transform.rotated(self.position))

    def turn_to(self, angle: float) -> None:
        """Set the position of the joint. A cyclic joint wraps it to half a turn."""
        self.position = math.remainder(angle, math.tau) if self.is_cyclic else angle


@dataclass(eq=False)
class VisionSensor(Node):
    """A pinhole camera along its z axis, with y up.

    angle: the angle across the longer side, in radians.
    background: its grey, from 0 to 1; None stands for the scene's.
    entity: the collection that it sees; -1 stands for all objects.
    sight: the last rendered or shown picture.
    has_result: its result can be read.
    """

    type = Type.VISION_SENSOR

    width: int = 16
    height: int = 16
    angle: float = math.pi / 3
    near: float = 0.01
    far: float = 10.0
    takes_external_pictures: bool = False
    is_perspective: bool = True
    background: Vector | None = None
    entity: int = -1
    sight: SensorPicture | None = None
    has_result: bool = False


@dataclass(eq=False)
class ProximitySensor(Node):
    """An ultrasonic sensor with a cone along its z axis.

    cone: the full opening angle of the cone, in radians.
    reach, offset: the end and the begin of the cone, in metres.
    setback: the distance of the rays' origin behind the sensor, in metres; distances are measured from the sensor.
    entity: the collection that it detects; -1 stands for all objects.
    """

    type = Type.PROXIMITY_SENSOR

    offset: float = 0.0
    reach: float = 1.0
    cone: float = math.pi / 6
    setback: float = 0.0
    entity: int = -1


@dataclass(eq=False)
class Script(Node):
    """A script of the scene, in Lua."""

    type = Type.SCRIPT

    text: str = ""
