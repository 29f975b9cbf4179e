"""Where things are, as Foxglove wants it told: times, quaternions, transforms between frames of reference."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from robotcore.description import Mount
from robotcore.geometry import Pose

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform, Quaternion, Timestamp
    from foxglove.messages import Pose as FoxglovePose

ODOMETRY, TRUE, BODY = "odom", "truth", "base_link"
"""Frames: where the robot began, the world in which a simulator knows where it is, and itself (REP 105)."""

TRUE_BODY = f"{BODY}_true"
"""Where the robot is by the simulator's word."""

ORIGIN = Pose(0.0, 0.0, 0.0)


def nanoseconds(seconds: float) -> int:
    """Return a time of the robot's clock in ns; before zero, and where it is no number, zero."""
    return round(1e9 * seconds) if 0 < seconds < math.inf else 0


def timestamp(seconds: float) -> Timestamp:
    """Return a time as Foxglove has it."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(nanoseconds(seconds), 1_000_000_000))


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the turn about x, then y, then z, in radians (Diebel, Representing Attitude, 2006, 5.8)."""
    from foxglove.messages import Quaternion

    cr, cp, cy = (math.cos(angle / 2) for angle in (roll, pitch, yaw))
    sr, sp, sy = (math.sin(angle / 2) for angle in (roll, pitch, yaw))
    return Quaternion(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def planar(pose: Pose) -> FoxglovePose:
    """Return a pose in the plane as one in space."""
    from foxglove.messages import Pose as FoxglovePose
    from foxglove.messages import Vector3

    position = Vector3(x=pose.x, y=pose.y, z=0.0)
    return FoxglovePose(position=position, orientation=quaternion(0.0, 0.0, pose.heading))


def placed(parent: str, child: str, pose: Pose, time: float) -> FrameTransform:
    """Return where a frame is in the plane of another."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=timestamp(time),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=pose.x, y=pose.y, z=0.0),
        rotation=quaternion(0.0, 0.0, pose.heading),
    )


def mounted(device: str, mount: Mount) -> FrameTransform:
    """Return where a device sits on the body."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=timestamp(0.0),
        parent_frame_id=BODY,
        child_frame_id=device,
        translation=Vector3(x=mount.x_m, y=mount.y_m, z=mount.z_m),
        rotation=quaternion(0.0, mount.pitch_rad, mount.yaw_rad),
    )


def optical(device: str) -> FrameTransform:
    """Return how a camera's picture lies in its frame: x to the right, y down, z ahead (REP 103)."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=timestamp(0.0),
        parent_frame_id=device,
        child_frame_id=optical_name(device),
        translation=Vector3(),
        rotation=quaternion(-math.pi / 2, 0.0, -math.pi / 2),
    )


def optical_name(device: str) -> str:
    """Return the name of the frame that a camera's picture lies in."""
    return f"{device}_optical"
