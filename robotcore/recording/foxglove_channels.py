"""The channels and coordinate frames of a recording, as Foxglove displays them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import cv2

from robotcore.description import Mount
from robotcore.geometry import Pose
from robotcore.hal.devices import (
    Angle,
    Battery,
    Camera,
    Device,
    Display,
    Encoder,
    Frame,
    Image,
    Range,
    RangeSensor,
    Voltage,
)
from robotcore.optics import Intrinsics
from robotcore.recording.codec import to_json
from robotcore.recording.mcap_file import McapFile
from robotcore.recording.message_schemas import ANGLE_SCHEMA, RANGE_SCHEMA, VOLTAGE_SCHEMA, Schema

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform, LaserScan, Quaternion, Timestamp
    from foxglove.messages import Pose as FoxglovePose


ODOMETRY, TRUE, BODY = "odom", "truth", "base_link"
"""The coordinate frames: the robot's start, the world of a simulator, and the robot's body.

The names of the first and the last are those of REP 105.
"""

TRUE_BODY = f"{BODY}_true"
"""The coordinate frame of the robot's body at its true pose in the simulator."""

ORIGIN = Pose(0.0, 0.0, 0.0)


def to_nanoseconds(seconds: float) -> int:
    """Return a time on the robot's clock, given in seconds, as nanoseconds.

    A time that is negative, infinite or NaN becomes 0.
    """
    return round(1e9 * seconds) if 0 < seconds < math.inf else 0


def to_timestamp(seconds: float) -> Timestamp:
    """Return a time as Foxglove's message."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(to_nanoseconds(seconds), 1_000_000_000))


def to_quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return a rotation as a quaternion.

    Source: J. Diebel, Representing Attitude (2006), section 5.8.

    roll, pitch, yaw: the angles about x, then y, then z, in radians.
    """
    from foxglove.messages import Quaternion

    cr, cp, cy = (math.cos(angle / 2) for angle in (roll, pitch, yaw))
    sr, sp, sy = (math.sin(angle / 2) for angle in (roll, pitch, yaw))
    return Quaternion(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def to_pose_message(pose: Pose) -> FoxglovePose:
    """Return a pose in the plane as Foxglove's message for a pose in space."""
    from foxglove.messages import Pose as FoxglovePose
    from foxglove.messages import Vector3

    position = Vector3(x=pose.x, y=pose.y, z=0.0)
    return FoxglovePose(position=position, orientation=to_quaternion(0.0, 0.0, pose.heading))


def build_transform(parent: str, child: str, pose: Pose, time: float) -> FrameTransform:
    """Return the message for the pose of the frame ``child`` in its ``parent`` frame.

    time: the time on the robot's clock, in seconds.
    """
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(time),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=pose.x, y=pose.y, z=0.0),
        rotation=to_quaternion(0.0, 0.0, pose.heading),
    )


def build_mount_transform(device: str, mount: Mount) -> FrameTransform:
    """Return the transform from the robot's body to a device."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(0.0),
        parent_frame_id=BODY,
        child_frame_id=device,
        translation=Vector3(x=mount.x_m, y=mount.y_m, z=mount.z_m),
        rotation=to_quaternion(0.0, mount.pitch_rad, mount.yaw_rad),
    )


def build_optical_transform(device: str) -> FrameTransform:
    """Return the transform from a camera to its pictures. In a picture, x is right, y down, z ahead (REP 103)."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(0.0),
        parent_frame_id=device,
        child_frame_id=build_optical_name(device),
        translation=Vector3(),
        rotation=to_quaternion(-math.pi / 2, 0.0, -math.pi / 2),
    )


def build_optical_name(device: str) -> str:
    """Return the name of the coordinate frame of a camera's pictures."""
    return f"{device}_optical"


DEVICE = "device"
"""The key of a channel's metadata that names the device."""

RUN, TICKS, RESULT, END, TRUTH, LOG, POSE = "/run", "/ticks", "/result", "/end", "/truth", "/log", "/pose"
TRANSFORMS, STATIC_TRANSFORMS = "/tf", "/tf_static"
"""Poses have two topics, as in ROS. A viewer that starts in the middle gets the last message of each topic."""

RESERVED = {RUN, TICKS, RESULT, END, TRUTH, LOG, POSE, TRANSFORMS, STATIC_TRANSFORMS}

RAYS = 9
"""The number of rays that show an ultrasonic sensor's cone as an arc."""

JPEG_QUALITY = 90

Write = Callable[[Any, float], None]
"""A function that writes a sample with its time on the robot's clock, in seconds."""


def build_topic(device: str) -> str:
    """Return the topic of a device: its name, with ``_device`` at the end if another channel has that topic."""
    topic = f"/{device}"
    return f"{topic}_device" if topic in RESERVED else topic


def open_channel(file: McapFile, device: Device, *, is_jpeg: bool) -> Write | None:
    """Open the channels of a device. Return the function that writes its samples; None if it has no samples.

    is_jpeg: whether to write the camera's pictures as JPEG.
    """
    match device:
        case Camera():
            _write_calibration(file, device)
            return (
                _open_jpegs(file, device.name, build_optical_name(device.name))
                if is_jpeg
                else _open_raw_images(file, device.name)
            )
        case Display():
            shown = _open_jpegs(file, device.name, device.name)
            return lambda frame, at: shown(replace(frame, time=at), at)
        case RangeSensor():
            return _open_ranges(file, device)
        case Encoder():
            return _open_numbers(file, device.name, ANGLE_SCHEMA)
        case Battery():
            return _open_numbers(file, device.name, VOLTAGE_SCHEMA)
    return None


def _open_raw_images(file: McapFile, device: str) -> Write:
    from foxglove.channels import RawImageChannel
    from foxglove.messages import RawImage

    channel = RawImageChannel(build_topic(device), metadata={DEVICE: device}, context=file.context)

    def write(frame: Frame, at: float) -> None:
        image = frame.image
        message = RawImage(
            timestamp=to_timestamp(frame.time),
            frame_id=build_optical_name(device),
            width=image.shape[1],
            height=image.shape[0],
            encoding="bgr8" if image.ndim == 3 else "mono8",
            step=image[0].nbytes,
            data=image.tobytes(),
        )
        channel.log(message, log_time=to_nanoseconds(at))

    return write


def _open_jpegs(file: McapFile, device: str, frame_id: str) -> Write:
    from foxglove.channels import CompressedImageChannel
    from foxglove.messages import CompressedImage

    channel = CompressedImageChannel(build_topic(device), metadata={DEVICE: device}, context=file.context)

    def write(frame: Frame, at: float) -> None:
        message = CompressedImage(
            timestamp=to_timestamp(frame.time),
            frame_id=frame_id,
            format="jpeg",
            data=_encode_jpeg(frame.image),
        )
        channel.log(message, log_time=to_nanoseconds(at))

    return write


def _encode_jpeg(image: Image) -> bytes:
    _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return encoded.tobytes()


def _write_calibration(file: McapFile, camera: Camera) -> None:
    from foxglove.channels import CameraCalibrationChannel
    from foxglove.messages import CameraCalibration

    intrinsics: Intrinsics = camera.intrinsics
    f, cx, cy = intrinsics.focal_length, intrinsics.cx, intrinsics.cy
    message = CameraCalibration(
        timestamp=to_timestamp(0.0),
        frame_id=build_optical_name(camera.name),
        width=intrinsics.width,
        height=intrinsics.height,
        K=[f, 0, cx, 0, f, cy, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0],
    )
    CameraCalibrationChannel(f"{build_topic(camera.name)}/calibration", context=file.context).log(message, log_time=0)


def _open_ranges(file: McapFile, sensor: RangeSensor) -> Write:
    from foxglove.channels import LaserScanChannel

    topic = build_topic(sensor.name)
    readings = file.json(topic, RANGE_SCHEMA, {DEVICE: sensor.name})
    scans = LaserScanChannel(f"{topic}/scan", context=file.context)

    def write(reading: Range, at: float) -> None:
        readings(to_json(reading), to_nanoseconds(at))
        scans.log(_build_scan(sensor, reading), log_time=to_nanoseconds(at))

    return write


def _build_scan(sensor: RangeSensor, reading: Range) -> LaserScan:
    """Return a reading as an arc across the sensor's cone, because the direction of the echo is unknown."""
    from foxglove.messages import LaserScan

    return LaserScan(
        timestamp=to_timestamp(reading.time),
        frame_id=sensor.name,
        pose=to_pose_message(ORIGIN),
        start_angle=-sensor.cone / 2,
        end_angle=sensor.cone / 2,
        ranges=[float(reading.distance)] * RAYS,
    )


def _open_numbers(file: McapFile, device: str, schema: Schema) -> Write:
    numbers = file.json(build_topic(device), schema, {DEVICE: device})

    def write(sample: Angle | Voltage, at: float) -> None:
        numbers(to_json(sample), to_nanoseconds(at))

    return write
