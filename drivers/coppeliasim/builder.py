"""Create, place and remove objects of a scene, and store notes on objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from drivers.coppeliasim.connection import LOADING_S, SimulatorConnection
from robotcore.description import Light, Mount
from robotcore.description.types import Colour
from robotcore.geometry import Pose

TAG = "robotcore"
"""The name of the custom data that holds the note of a root object that this driver has made."""

NO_UNDO = "[]"
"""The note of a root object without undo calls: an empty JSON list."""

_EXCLUDED = 1


class CollisionMask(IntEnum):
    """Collision masks of shapes. Two shapes collide if their masks have a common bit.

    For two shapes of the same model, the low byte counts. For other shapes, the high byte counts. Wheels and casters
    collide with the floor only. The body collides with the floor, and with the prisms and balls of the world.
    """

    FLOOR = 0x01FF
    THING = 0x02FF
    BODY = 0x0301
    WHEEL = 0x0102
    CASTER = 0x0104


class SceneBuilder:
    """Creates and changes objects of a scene. The simulation must be stopped."""

    def __init__(self, connection: SimulatorConnection) -> None:
        self._connection = connection
        self.constant = connection.constant

    def call(self, name: str, *arguments: object) -> object:
        """Call a function of the API with the time limit `LOADING_S`, and return its result."""
        return self._connection.sim(name, *arguments, within_s=LOADING_S)

    def make(self, name: str, *arguments: object) -> int:
        """Call a function of the API that returns a handle, and return the handle."""
        return self._connection.call_as(int, name, *arguments)

    def create_dummy(self, alias: str) -> int:
        """Create a dummy, and return its handle. A dummy is a point that can be the parent of other objects."""
        handle = self.make("createDummy", 0.01)
        self.call("setObjectAlias", handle, alias)
        return handle

    def create_shape(
        self,
        kind: str,
        size: Sequence[float],
        frame: Placement,
        colour: Colour,
        mask: CollisionMask,
        alias: str,
        parent: int = -1,
    ) -> int:
        """Create a shape that the physics engine does not move, and return its handle.

        kind: ``cuboid``, ``spheroid`` or ``cylinder``.
        size: the lengths of the bounding box along x, y and z, in metres.
        frame: the frame of the shape in the world.
        alias: the name of the shape.
        parent: the handle of the parent; -1 means no parent.
        """
        handle = self.make("createPrimitiveShape", self.constant(f"primitiveshape_{kind}"), list(size), 0)
        self.call("setShapeColor", handle, None, self.constant("colorcomponent_ambient_diffuse"), _to_rgb(colour))
        self.set_int(handle, "shapeintparam_static", 1)
        self.set_int(handle, "shapeintparam_respondable", 1)
        self.set_int(handle, "shapeintparam_respondable_mask", mask)
        self.put(handle, frame, alias, parent)
        return handle

    def put(self, handle: int, frame: Placement, alias: str, parent: int) -> None:
        """Set an object's frame in the world, its name, and the handle of its parent; -1 means no parent."""
        self.call("setObjectPose", handle, list(frame))
        self.call("setObjectAlias", handle, alias)
        if parent >= 0:
            self.call("setObjectParent", handle, parent, True)

    def set_int(self, handle: int, parameter: str, value: int) -> None:
        """Set an integer parameter of an object.

        parameter: the name of the API constant that identifies the parameter.
        """
        self.call("setObjectInt32Param", handle, self.constant(parameter), int(value))

    def make_dynamic(self, shape: int, mass_kg: float, inertia: Sequence[float], centre_x: float = 0.0) -> None:
        """Let the physics engine move a shape, and set its mass, inertia and centre of mass.

        inertia: the moments of inertia about x, y and z, in kg·m².
        centre_x: the position of the centre of mass on the shape's x axis, in metres.
        """
        self.set_int(shape, "shapeintparam_static", 0)
        self.call("setShapeMass", shape, mass_kg)
        xx, yy, zz = inertia
        at = [1, 0, 0, centre_x, 0, 1, 0, 0, 0, 0, 1, 0]
        self.call("setShapeInertia", shape, [xx, 0, 0, 0, yy, 0, 0, 0, zz], at)

    def set_friction(self, shape: int, friction: float) -> None:
        """Set the coefficient of friction of a shape, for Bullet 2.78 and for newer versions of Bullet."""
        for parameter in ("bullet_body_oldfriction", "bullet_body_friction"):
            self.call("setEngineFloatParam", self.constant(parameter), shape, friction)

    def list_tree(self, root: str | int, kind: str = "handle_all", options: int = 0) -> list[int]:
        """Return the handles of an object and of all objects below it.

        root: the handle of the object, or the name of an API constant such as ``handle_scene``.
        kind: the name of the API constant of an object type. Objects of other types are omitted.
        options: the option bits of the API function ``getObjectsInTree``.
        """
        base = self.constant(root) if isinstance(root, str) else root
        return self._connection.call_as(list, "getObjectsInTree", base, self.constant(kind), options)

    def read_path(self, handle: int) -> str:
        """Return the path of an object in the scene."""
        return self._connection.call_as(str, "getObjectAlias", handle, 1)

    def read_placement(self, handle: int) -> Placement:
        """Return the frame of an object in the world."""
        return self._connection.call_as(Placement.from_answer, "getObjectPose", handle)

    def read_lamp(self, handle: int) -> tuple[object, ...]:
        """Return whether a lamp is on, an unused value, and the lamp's diffuse and specular colours."""
        return self._connection.call_as(tuple, "getLightParameters", handle)

    def create_collection(self, root: int, *, without: int = -1) -> int:
        """Create a collection of an object and all objects below it, and return the handle of the collection.

        without: the handle of an object to leave out; -1 means none.
        """
        handle = self.make("createCollection", 0)
        self.call("addItemToCollection", handle, self.constant("handle_tree"), root, 0)
        if without >= 0:
            self.call("addItemToCollection", handle, self.constant("handle_single"), without, _EXCLUDED)
        return handle

    def write_note(self, handle: int, note: str, tag: str = TAG) -> None:
        """Store a note in the custom data of an object. The scene file contains it.

        A root object with a note of the default tag was made by this driver, with all objects below it.
        """
        self.call("writeCustomStringData", handle, tag, note)

    def read_note(self, handle: int, tag: str = TAG) -> str:
        """Return the note that `write_note` has stored in an object; "" if there is none."""
        note = self._connection.sim("readCustomStringData", handle, tag)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def remove_tree(self, root: int) -> None:
        """Remove an object and all objects below it."""
        self.call("removeObjects", self.list_tree(root))


def _to_rgb(colour: Colour) -> list[float]:
    return [part / 255 for part in colour]


class Placement(NamedTuple):
    """A frame in the world or in another frame: a position in metres and a rotation as a quaternion."""

    x: float
    y: float
    z: float
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @classmethod
    def from_answer(cls, answer: Any) -> Placement:
        """Convert a result of the API to a frame. Raises TypeError or ValueError if the result is not a frame."""
        x, y, z, qx, qy, qz, qw = map(float, answer)
        return cls(x, y, z, qx, qy, qz, qw)

    def compose(self, local: Placement) -> Placement:
        """Return the frame in the world of a frame that is given relative to this frame.

        >>> Placement(1.0, 2.0, 0.0).compose(Placement(0.5, 0.0, 0.0))[:3]
        (1.5, 2.0, 0.0)
        """
        x, y, z = self._rotate(local.x, local.y, local.z)
        return Placement(self.x + x, self.y + y, self.z + z, *_multiply(self[3:], local[3:]))

    def _rotate(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        inverse = (-self.qx, -self.qy, -self.qz, self.qw)
        rotated = _multiply(_multiply(self[3:], (x, y, z, 0.0)), inverse)
        return rotated[0], rotated[1], rotated[2]


Quaternion = tuple[float, ...]

AXLE = Placement(0.0, 0.0, 0.0, -math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The rotation of a wheel's joint in the robot's frame. The z axis of the joint points to the robot's left."""

FORWARD = Placement(0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""The rotation of a sensor in the frame of its mount. The sensor's z axis points forward, x to the left, and y up."""


def place_on_floor(pose: Pose) -> Placement:
    """Return the frame in the world of a planar pose, at the height of the floor."""
    return Placement(pose.x, pose.y, 0.0, *_rotate_about_z(pose.heading))


def place_mount(mount: Mount, behind_m: float = 0.0) -> Placement:
    """Return the frame of a sensor in the robot's frame.

    behind_m: the distance from the mount backwards to the sensor, in metres.
    """
    half = mount.pitch_rad / 2
    turn = _multiply(_rotate_about_z(mount.yaw_rad), (0.0, math.sin(half), 0.0, math.cos(half)))
    frame = Placement(mount.x_m, mount.y_m, mount.z_m, *turn)
    return frame.compose(FORWARD._replace(x=-behind_m))


def place_lamp(light: Light) -> Placement:
    """Return the frame in the world of a lamp, 3 m above the floor. The lamp's z axis is the direction of the light."""
    tilt = -math.pi / 2 - light.elevation_rad
    turn = _multiply(_rotate_about_z(light.azimuth_rad), (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2)))
    return Placement(0.0, 0.0, 3.0, *turn)


def _rotate_about_z(angle: float) -> Quaternion:
    return 0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)


def _multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
