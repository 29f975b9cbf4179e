"""Make objects in a scene: their poses, shapes, parameters, marks and removal."""

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
"""Objects that carry custom data of this name are ours to remove."""

NO_UNDO = "[]"
"""The note on one of ours that there is nothing to be undone."""


_TAKEN_OUT = 1


class CollisionMask(IntEnum):
    """Who collides with whom: the high byte across models, the low byte within one.

    Wheels and caster meet the floor only; the body meets both.
    """

    FLOOR = 0x01FF
    THING = 0x02FF
    BODY = 0x0301
    WHEEL = 0x0102
    CASTER = 0x0104


class SceneBuilder:
    """Makes objects in a scene that is stopped."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self.constant = connection.constant

    def call(self, name: str, *arguments: object) -> object:
        """Call a function of the API, and wait as long as loading may take."""
        return self._connection.sim(name, *arguments, within_s=LOADING_S)

    def make(self, name: str, *arguments: object) -> int:
        """Call a function that makes an object; return its handle."""
        return self._connection.call_as(int, name, *arguments)

    def dummy(self, alias: str) -> int:
        """Make a point that others can be put under."""
        handle = self.make("createDummy", 0.01)
        self.call("setObjectAlias", handle, alias)
        return handle

    def shape(
        self,
        kind: str,
        size: Sequence[float],
        place: Placement,
        colour: Colour,
        mask: CollisionMask,
        alias: str,
        parent: int = -1,
    ) -> int:
        """Make a pure shape that others bump into and that stands still; ``size`` is its bounding box in metres."""
        handle = self.make("createPrimitiveShape", self.constant(f"primitiveshape_{kind}"), list(size), 0)
        self.call("setShapeColor", handle, None, self.constant("colorcomponent_ambient_diffuse"), _rgb(colour))
        self.set_int(handle, "shapeintparam_static", 1)
        self.set_int(handle, "shapeintparam_respondable", 1)
        self.set_int(handle, "shapeintparam_respondable_mask", mask)
        self.put(handle, place, alias, parent)
        return handle

    def put(self, handle: int, place: Placement, alias: str, parent: int) -> None:
        """Place an object in the world, name it, and put it under its parent; -1 is none."""
        self.call("setObjectPose", handle, list(place))
        self.call("setObjectAlias", handle, alias)
        if parent >= 0:
            self.call("setObjectParent", handle, parent, True)

    def set_int(self, handle: int, parameter: str, value: int) -> None:
        """Set an object's whole number by the parameter's name."""
        self.call("setObjectInt32Param", handle, self.constant(parameter), int(value))

    def let_move(self, shape: int, mass_kg: float, inertia: Sequence[float], centre_x: float = 0.0) -> None:
        """Let physics move a shape: its mass, its moments of inertia in kg·m², where on its x axis its mass is."""
        self.set_int(shape, "shapeintparam_static", 0)
        self.call("setShapeMass", shape, mass_kg)
        xx, yy, zz = inertia
        at = [1, 0, 0, centre_x, 0, 1, 0, 0, 0, 0, 1, 0]
        self.call("setShapeInertia", shape, [xx, 0, 0, 0, yy, 0, 0, 0, zz], at)

    def set_friction(self, shape: int, friction: float) -> None:
        """Set what Bullet 2.78 goes by, and what newer ones do."""
        for parameter in ("bullet_body_oldfriction", "bullet_body_friction"):
            self.call("setEngineFloatParam", self.constant(parameter), shape, friction)

    def tree(self, root: str | int, kind: str = "handle_all", options: int = 0) -> list[int]:
        """Return what is in a tree, by the constant's name or a root's handle, of a kind."""
        base = self.constant(root) if isinstance(root, str) else root
        return self._connection.call_as(list, "getObjectsInTree", base, self.constant(kind), options)

    def path(self, handle: int) -> str:
        """Return an object's path."""
        return self._connection.call_as(str, "getObjectAlias", handle, 1)

    def place(self, handle: int) -> Placement:
        """Return where an object is in the world."""
        return self._connection.call_as(Placement.of, "getObjectPose", handle)

    def lamp(self, handle: int) -> tuple[object, ...]:
        """Return a lamp's state, a relic, and its diffuse and specular colours."""
        return self._connection.call_as(tuple, "getLightParameters", handle)

    def collection(self, root: int, *, without: int = -1) -> int:
        """Make a collection of a tree, but for one object."""
        handle = self.make("createCollection", 0)
        self.call("addItemToCollection", handle, self.constant("handle_tree"), root, 0)
        if without >= 0:
            self.call("addItemToCollection", handle, self.constant("handle_single"), without, _TAKEN_OUT)
        return handle

    def mark(self, handle: int, note: str, tag: str = TAG) -> None:
        """Mark an object, and all under it, as ours."""
        self.call("writeCustomStringData", handle, tag, note)

    def note_on(self, handle: int, tag: str = TAG) -> str:
        """Return the note on an object that is ours; empty where it is not."""
        note = self._connection.sim("readCustomStringData", handle, tag)
        return note.decode(errors="replace") if isinstance(note, bytes) else str(note or "")

    def remove_tree(self, root: int) -> None:
        """Remove an object and all under it."""
        self.call("removeObjects", self.tree(root))


def _rgb(colour: Colour) -> list[float]:
    return [part / 255 for part in colour]


class Placement(NamedTuple):
    """A frame in the world, or in another frame."""

    x: float
    y: float
    z: float
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @classmethod
    def of(cls, answer: Any) -> Placement:
        """Return the pose that the API tells; raises TypeError or ValueError where it is none."""
        x, y, z, qx, qy, qz, qw = map(float, answer)
        return cls(x, y, z, qx, qy, qz, qw)

    def at(self, local: Placement) -> Placement:
        """Return in the world what is ``local`` in this frame."""
        x, y, z = self._turned(local.x, local.y, local.z)
        return Placement(self.x + x, self.y + y, self.z + z, *_product(self[3:], local[3:]))

    def _turned(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        inverse = (-self.qx, -self.qy, -self.qz, self.qw)
        turned = _product(_product(self[3:], (x, y, z, 0.0)), inverse)
        return turned[0], turned[1], turned[2]


Quaternion = tuple[float, ...]

AXLE = Placement(0.0, 0.0, 0.0, -math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Its z axis points to the robot's left: a joint that turns forward."""

FORWARD = Placement(0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""Its z axis points forward, x to the left, y up: a sensor that looks ahead, upright."""


def place_on_floor(pose: Pose) -> Placement:
    """Return the frame of a pose in plan."""
    return Placement(pose.x, pose.y, 0.0, *_about_z(pose.heading))


def place_mount(mount: Mount, behind_m: float = 0.0) -> Placement:
    """Return the frame of a sensor that looks as its mount says, begun so far behind it, in the robot's frame."""
    half = mount.pitch_rad / 2
    turn = _product(_about_z(mount.yaw_rad), (0.0, math.sin(half), 0.0, math.cos(half)))
    frame = Placement(mount.x_m, mount.y_m, mount.z_m, *turn)
    return frame.at(FORWARD._replace(x=-behind_m))


def place_lamp(light: Light) -> Placement:
    """Return the frame of a lamp, high above, whose z axis points where its light goes."""
    tilt = -math.pi / 2 - light.elevation_rad
    turn = _product(_about_z(light.azimuth_rad), (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2)))
    return Placement(0.0, 0.0, 3.0, *turn)


def _about_z(angle: float) -> Quaternion:
    return 0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
