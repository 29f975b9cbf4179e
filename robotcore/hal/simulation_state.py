"""The true state of a simulated robot and its world, from which kinds of devices are simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotcore.description import RobotDescription, WorldDescription
from robotcore.description.floor_colours import FloorColours
from robotcore.geometry import Pose, Twist
from robotcore.hal.clock import Clock
from robotcore.hal.joint import Joints
from robotcore.hal.noise import draw_noise, draw_noises

__all__ = ["SimulationState"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulationState:
    """The state of a simulated robot and its world. Each simulator in this process provides one to simulate devices.

    An app's `verify` gets a `Truth`.

    >>> import numpy as np
    >>> from robotcore import Pose, Twist
    >>> from robotcore.description import load_robot, load_world
    >>> from robotcore.hal.clock import SteppedClock
    >>> state = SimulationState(
    ...     load_robot("rover"), load_world("open"), SteppedClock(20, lambda steps: None), lambda: Pose(0.0, 0.0, 0.0),
    ...     lambda: Twist(0.2, 0.0), lambda start, rays, reach: np.full(len(rays), 1.0), lambda: (), seed=7,
    ... )
    >>> state.pose(), state.twist().linear, state.list_contact_bearings()
    (Pose(x=0 m, y=0 m, heading=0 rad), 0.2, ())
    >>> state.draw_noise("flow:speed", 0.1, time=0.5) == state.draw_noise("flow:speed", 0.1, time=0.5)
    True
    """

    robot: RobotDescription
    world: WorldDescription
    clock: Clock
    """The simulated clock."""
    pose: Callable[[], Pose]
    """Returns the true pose of the axle's centre in the world."""
    twist: Callable[[], Twist]
    """Returns the true velocity of the axle's centre."""
    cast: Callable[[Array, Array, float], Array]
    """Returns the length of each ray up to its first hit, (n,) in metres, and ``inf`` without a hit.

    Its arguments are the common start of the rays, (3,) in metres, their unit vectors, (n, 3), both in the robot's
    frame, and the length in metres up to which hits count at least. The rays must be horizontal. They ignore the robot
    and the floor.
    """
    list_touched_bodies: Callable[[], Collection[str]]
    """Returns the names of the bodies that the robot touches now."""
    seed: int
    """The seed of the run."""
    measure_wheel_angles: Callable[[], Mapping[str, float]] = dict
    """Returns the true angle of the wheel of each motor of the drive, in radians, by the name of the motor."""
    indicator_commands: dict[str, Any] = field(default_factory=dict)
    """The last command of each light and each buzzer, by its name."""
    touches: dict[str, int] = field(default_factory=dict)
    """The devices that a simulated person touches, such as a pressed button, by name.

    The value is the part that is touched: 0, or the number of the sensor of a row that a dark object covers.
    """

    def draw_noise(self, key: str, sigma: float, time: float) -> float:
        """Return normal noise with the standard deviation ``sigma`` at a time in seconds.

        The seed, the key and the time determine it. A kind's key begins with the name of its device.
        """
        return draw_noise(f"{self.seed}:{key}", sigma, time) if sigma else 0.0

    def draw_noises(self, key: str, sigma: float, time: float, count: int) -> Array:
        """Return ``count`` values of normal noise, like `draw_noise`."""
        return draw_noises(f"{self.seed}:{key}", sigma, time, count) if sigma else np.zeros(count)

    @cached_property
    def joints(self) -> Joints:
        """The true motion of the servos."""
        return Joints(self.robot, self.clock)

    def list_contact_bearings(self) -> tuple[float, ...]:
        """Return the directions of the present contacts in the robot's frame, in radians, positive to the left.

        The direction of a contact is that of the body's point that is nearest to the middle of the robot.
        """
        names = self.list_touched_bodies()
        if not names:
            return ()
        pose, middle = self.pose(), self.robot.body.centre_x_m
        outlines = {body.name: body.outline for body in (*self.world.prisms, *self.world.targets)}
        nearest = (_nearest_point(outlines[name], pose.to_world(middle, 0.0)) for name in sorted(names))
        local = (pose.to_local(*point) for point in nearest)
        return tuple(math.atan2(y, x - middle) for x, y in local)

    def measure_floor_colours(self, points: Sequence[tuple[float, float]]) -> Array:
        """Return red, green and blue of the floor at points in the robot's frame, (n, 3), from 0 to 255.

        The light is not taken into account.
        """
        pose = self.pose()
        return self._floor.measure(np.array([pose.to_world(x, y) for x, y in points]))

    @cached_property
    def _floor(self) -> FloorColours:
        return FloorColours(self.world)


def _nearest_point(outline: tuple[tuple[float, float], ...], point: tuple[float, float]) -> tuple[float, float]:
    """Return the point of an outline that is nearest to ``point``."""
    start = np.array(outline)
    edge = np.roll(start, -1, axis=0) - start
    along = np.clip(((np.array(point) - start) * edge).sum(axis=1) / (edge**2).sum(axis=1), 0.0, 1.0)
    candidates = start + along[:, None] * edge
    x, y = candidates[((candidates - np.array(point)) ** 2).sum(axis=1).argmin()]
    return float(x), float(y)
