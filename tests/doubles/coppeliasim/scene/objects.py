"""The objects of a scene, and the errors of the real server."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tests.doubles.coppeliasim.scene.poses import ORIGIN, Transform, Vector

if TYPE_CHECKING:
    from tests.doubles.coppeliasim.scene.rendering import View


class SceneError(Exception):
    """An error in a call of a client. Its text is sent to the client.

    where: the place in the server's scripts that the real server names; "" stands for the called function.
    """

    def __init__(self, text: str, where: str = "") -> None:
        super().__init__(text)
        self.where = where


class NoObjectError(SceneError):
    """No object has the handle, or the path."""

    def __init__(self, text: str = "object does not exist.", where: str = "") -> None:
        super().__init__(text, where)


Pixels = NDArray[np.uint8]
"""Shape (height, width, 3): red, green, blue; row 0 at the bottom, column 0 on the left."""
Depths = NDArray[np.float32]
"""Shape (height, width): metres along the optical axis."""


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


class Primitive(IntEnum):
    """The values of the API's ``primitiveshape_...``."""

    CUBOID = 3
    SPHEROID = 4
    CYLINDER = 5


class JointMode(IntEnum):
    """The control modes of a dynamic joint: the values of the API's ``jointdynctrl_...``."""

    FREE = 0
    VELOCITY = 4


@dataclass(eq=False)
class Node:
    """An object of a scene. Cameras, dummies and force sensors have no further properties.

    local: the pose in the frame of the parent.
    flat_name: the name in V-REP, such as ``bubbleRob_leftMotor``.
    is_model_base: the paths of the objects below contain the name of this object.
    parameters: stored parameters that have no effect.
    """

    alias: str
    type: Type = Type.DUMMY
    handle: int = -1
    parent: Node | None = field(default=None, repr=False)
    children: list[Node] = field(default_factory=list, repr=False)
    local: Transform = ORIGIN
    flat_name: str = ""
    is_model_base: bool = False
    parameters: dict[object, object] = field(default_factory=dict, repr=False)


@dataclass(eq=False)
class Lamp(Node):
    """A lamp, which has no effect. ``light``: whether it is on, an unused value, its diffuse and specular colours."""

    type: Type = Type.LIGHT
    light: tuple[object, ...] = (1, [0.0] * 3, [0.5] * 3, [0.5] * 3)


@dataclass(eq=False)
class Shape(Node):
    """A primitive shape. ``size`` has the lengths along x, y and z in metres. The ``colour`` is from 0 to 1."""

    type: Type = Type.SHAPE
    primitive: Primitive = Primitive.CUBOID
    size: Vector = (0.1, 0.1, 0.1)
    colour: Vector = (1.0, 1.0, 1.0)
    is_static: bool = True


@dataclass(eq=False)
class Joint(Node):
    """A revolute joint about its z axis, in radians and rad/s.

    lag: the time constant with which a motor follows its target, in seconds.

    The position of a cyclic joint is within half a turn.
    """

    type: Type = Type.JOINT
    control: int = JointMode.FREE
    position: float = 0.0
    target_velocity: float = 0.0
    is_cyclic: bool = True
    lag: float = 0.0

    def turn_to(self, angle: float) -> None:
        """Set the position of the joint. A cyclic joint wraps it to half a turn."""
        self.position = math.remainder(angle, math.tau) if self.is_cyclic else angle


@dataclass(eq=False)
class Sensor(Node):
    """A sensor. Its z axis points forward, and x to the left.

    explicit: whether it measures only on request (explicit handling).
    entity: the handle of the collection of objects that it sees; -1 stands for all objects.
    """

    explicit: bool = False
    entity: int = -1


@dataclass(eq=False)
class VisionSensor(Sensor):
    """A pinhole camera with y up.

    angle: the angle across the longer side, in radians.
    background: its colour, from 0 to 1; None stands for the scene's.
    takes_external_pictures: it shows received pictures only.
    view: the last rendered or shown picture.
    """

    type: Type = Type.VISION_SENSOR
    width: int = 16
    height: int = 16
    angle: float = math.pi / 3
    near: float = 0.01
    far: float = 10.0
    takes_external_pictures: bool = False
    is_perspective: bool = True
    background: Vector | None = None
    view: View | None = None


@dataclass(eq=False)
class ProximitySensor(Sensor):
    """An ultrasonic sensor with a flat cone.

    cone: the full opening angle of the cone, in radians.
    reach: the length of the cone, in metres.
    setback: the distance of the rays' origin behind the sensor, in metres; distances are measured from the sensor.
    """

    type: Type = Type.PROXIMITY_SENSOR
    reach: float = 1.0
    cone: float = math.pi / 6
    setback: float = 0.0
