"""Create, place, mark and remove objects of a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from drivers.coppeliasim.connection import LOADING_S, Connection
from robotcore.description import Light, Mount
from robotcore.description.types import Colour
from robotcore.geometry import Pose

TAG = "robotcore"
"""The name of the custom data that marks objects as made by this driver."""

NO_UNDO = "[]"
"""The note on a root object that has no changes to undo: an empty JSON list."""

_EXCLUDED = 1


class CollisionMask(IntEnum):
    """Collision masks of shapes. Two shapes collide if their masks share a bit.

    For shapes of different models the high byte counts, for shapes of one model the low byte.
    Wheels and casters collide with the floor only. The body collides with the floor and with the things of the world.
    """

    FLOOR = 0x01FF
    THING = 0x02FF
    BODY = 0x0301
    WHEEL = 0x0102
    CASTER = 0x0104


class SceneBuilder:
    """Creates objects in a scene whose simulation is stopped."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self.constant = connection.constant

    def call(self, name: str, *arguments: object) -> object:
        """Call a function of the API with the time limit `LOADING_S`."""
        return self._connection.sim(name, *arguments, within_s=LOADING_S)

    def make(self, name: str, *arguments: object) -> int:
        """Call a function that returns a handle."""
        return self._connection.call_as(int, name, *arguments)

    def create_dummy(self, alias: str) -> int:
        """Create a dummy, which is a point that can be the parent of other objects, and return its handle."""
        handle = self.make("createDummy", 0.01)
        self.call("setObjectAlias", handle, alias)
        return handle

    def create_shape(
        self,
        kind: str,
        size: Sequence[float],
        place: Placement,
        colour: Colour,
        mask: CollisionMask,
        alias: str,
        parent: int = -1,
    ) -> int:
        """Create a shape that physics does not move, and return its handle.

        kind: the last word of the API's constant: ``cuboid``, ``spheroid`` or ``cylinder``.
        size: the bounding box in metres.
        place: the frame of the shape in the world.
        alias: its name.
        parent: the handle of its parent; -1 means no parent.
        """
        handle = self.make("createPrimitiveShape", self.constant(f"primitiveshape_{kind}"), list(size), 0)
        self.call("setShapeColor", handle, None, self.constant("colorcomponent_ambient_diffuse"), _to_rgb(colour))
        self.set_int(handle, "shapeintparam_static", 1)
        self.set_int(handle, "shapeintparam_respondable", 1)
        self.set_int(handle, "shapeintparam_respondable_mask", mask)
        self.put(handle, place, alias, parent)
        return handle

    def put(self, handle: int, place: Placement, alias: str, parent: int) -> None:
        """Set an object's frame in the world, its name and its parent. A parent of -1 means none."""
        self.call("setObjectPose", handle, list(place))
        self.call("setObjectAlias", handle, alias)
        if parent >= 0:
            self.call("setObjectParent", handle, parent, True)

    def set_int(self, handle: int, parameter: str, value: int) -> None:
        """Set an integer parameter of an object. ``parameter`` is the name of the parameter's constant in the API."""
        self.call("setObjectInt32Param", handle, self.constant(parameter), int(value))

    def make_dynamic(self, shape: int, mass_kg: float, inertia: Sequence[float], centre_x: float = 0.0) -> None:
        """Let the physics engine move a shape.

        inertia: the moments of inertia about x, y and z, in kg·m².
        centre_x: the position of the centre of mass on the x axis, in metres.
        """
        self.set_int(shape, "shapeintparam_static", 0)
        self.call("setShapeMass", shape, mass_kg)
        xx, yy, zz = inertia
        at = [1, 0, 0, centre_x, 0, 1, 0, 0, 0, 0, 1, 0]
        self.call("setShapeInertia", shape, [xx, 0, 0, 0, yy, 0, 0, 0, zz], at)

    def set_friction(self, shape: int, friction: float) -> None:
        """Set the friction of a shape in Bullet 2.78 and in newer versions of Bullet, which have separate settings."""
        for parameter in ("bullet_body_oldfriction", "bullet_body_friction"):
            self.call("setEngineFloatParam", self.constant(parameter), shape, friction)

    def list_tree(self, root: str | int, kind: str = "handle_all", options: int = 0) -> list[int]:
        """Return the handles of the objects in a tree.

        root: the handle of the topmost object, or the name of an API constant such as ``handle_scene``.
        kind: the name of the API constant for the type of the objects.
        options: the option bits of the API's function ``getObjectsInTree``.
        """
        base = self.constant(root) if isinstance(root, str) else root
        return self._connection.call_as(list, "getObjectsInTree", base, self.constant(kind), options)

    def read_path(self, handle: int) -> str:
        """Return an object's path."""
        return self._connection.call_as(str, "getObjectAlias", handle, 1)

    def read_placement(self, handle: int) -> Placement:
        """Return the frame of an object in the world."""
        return self._connection.call_as(Placement.of, "getObjectPose", handle)

    def read_lamp(self, handle: int) -> tuple[object, ...]:
        """Return a lamp's state, an unused value, and its diffuse and specular colours."""
        return self._connection.call_as(tuple, "getLightParameters", handle)

    def create_collection(self, root: int, *, without: int = -1) -> int:
        """Create a collection of an object and all objects below it, and return its handle.

        without: the handle of an object to leave out; -1 means none.
        """
        handle = self.make("createCollection", 0)
        self.call("addItemToCollection", handle, self.constant("handle_tree"), root, 0)
        if without >= 0:
            self.call("addItemToCollection", handle, self.constant("handle_single"), without, _EXCLUDED)
        return handle

    def mark(self, handle: int, note: str, tag: str = TAG) -> None:
        """Store a note on an object, which marks this object and all objects below it as made by this driver."""
        self.call("writeCustomStringData", handle, tag, note)

    def read_note(self, handle: int, tag: str = TAG) -> str:
        """Return the note that `mark` has stored on an object; "" if there is none."""
        note = self._connection.sim("readCustomStringData", handle, tag)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def remove_tree(self, root: int) -> None:
        """Remove an object and all objects below it."""
        self.call("removeObjects", self.list_tree(root))


def _to_rgb(colour: Colour) -> list[float]:
    return [part / 255 for part in colour]


class Placement(NamedTuple):
    """A frame relative to the world or to another frame: a position in metres and a quaternion."""

    x: float
    y: float
    z: float
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @classmethod
    def of(cls, answer: Any) -> Placement:
        """Convert an answer of the API to a frame. Raises TypeError or ValueError if the answer is not a frame."""
        x, y, z, qx, qy, qz, qw = map(float, answer)
        return cls(x, y, z, qx, qy, qz, qw)

    def compose(self, local: Placement) -> Placement:
        """Return the world frame of ``local``, which is given relative to this frame.

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
"""The frame of a wheel's joint relative to the robot: the joint's z axis points to the robot's left."""

FORWARD = Placement(0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""The frame of a sensor relative to its mount: z points forward, x to the left, y up."""


def place_on_floor(pose: Pose) -> Placement:
    """Return the world frame of a planar pose, at the height of the floor."""
    return Placement(pose.x, pose.y, 0.0, *_rotate_about_z(pose.heading))


def place_mount(mount: Mount, behind_m: float = 0.0) -> Placement:
    """Return the frame of a sensor in the robot's frame.

    behind_m: the distance by which the frame is shifted backwards from the mount, in metres.
    """
    half = mount.pitch_rad / 2
    turn = _multiply(_rotate_about_z(mount.yaw_rad), (0.0, math.sin(half), 0.0, math.cos(half)))
    frame = Placement(mount.x_m, mount.y_m, mount.z_m, *turn)
    return frame.compose(FORWARD._replace(x=-behind_m))


def place_lamp(light: Light) -> Placement:
    """Return the frame of a lamp high above the floor; its z axis is the direction of the light."""
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
