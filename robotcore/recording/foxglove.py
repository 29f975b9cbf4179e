"""Channels, schemas and coordinate frames of a recording, as Foxglove displays them.

A JSON message leaves out empty fields. A number that is not finite is a string.
"""

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

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform, LaserScan, Quaternion, Timestamp
    from foxglove.messages import Pose as FoxglovePose


Schema = dict[str, Any]

_NUMBER: Schema = {"type": "number"}
_WHOLE: Schema = {"type": "integer"}
_TEXT: Schema = {"type": "string"}


def _object(title: str = "", **properties: Schema) -> Schema:
    named = {"title": f"robotcore.{title}"} if title else {}
    return {**named, "type": "object", "properties": properties}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


_WHEELS = _object(left=_NUMBER, right=_NUMBER)
_POSE = _object(x=_NUMBER, y=_NUMBER, heading=_NUMBER)
_ERROR = _object(kind=_TEXT, message=_TEXT, attributes=_object())
_READ = _object(device=_TEXT, sequence=_WHOLE, time=_NUMBER, number=_WHOLE, error=_ERROR, by=_TEXT)
_INTERVENTION = _object(time=_NUMBER, cause=_TEXT, asked=_WHEELS, sent=_WHEELS)

TICK_SCHEMA = _object(
    "Tick",
    number=_WHOLE,
    time=_NUMBER,
    state=_TEXT,
    reads=_list(_READ),
    asks=_list(_object(asked=_WHEELS, given=_WHEELS, error=_ERROR)),
    motor_asks=_list(_object(device=_TEXT, asked=_NUMBER, given=_NUMBER, error=_ERROR)),
    turned=_list(_object(angles=_WHEELS, error=_ERROR)),
    standing=_list(_WHEELS),
    pose=_POSE,
    asked=_WHEELS,
    sent=_WHEELS,
    interventions=_list(_INTERVENTION),
    commit_error=_ERROR,
    shown=_list(_object(device=_TEXT, number=_WHOLE, error=_ERROR)),
    error=_ERROR,
    warnings=_list(_TEXT),
)
RANGE_SCHEMA = _object("Range", distance=_NUMBER, time=_NUMBER, sequence=_WHOLE, point=_list(_NUMBER))
ANGLE_SCHEMA = _object("Angle", angle=_NUMBER, time=_NUMBER, sequence=_WHOLE)
VOLTAGE_SCHEMA = _object("Voltage", voltage=_NUMBER, time=_NUMBER, sequence=_WHOLE)
TRUTH_SCHEMA = _object("Truth", tick=_WHOLE, time=_NUMBER, pose=_POSE, contacts=_WHOLE)
RUN_SCHEMA = _object("Run", request=_object(), devices=_list(_TEXT), started=_TEXT)
RESULT_SCHEMA = _object("Result", outcome=_TEXT, reason=_TEXT, exit_status=_WHOLE, ticks=_WHOLE)
END_SCHEMA = _object("End", reason=_TEXT)


ODOMETRY, TRUE, BODY = "odom", "truth", "base_link"
"""Frames: where the robot began, the world in which a simulator knows where it is, and itself (REP 105)."""

TRUE_BODY = f"{BODY}_true"
"""Where the robot is by the simulator's word."""

ORIGIN = Pose(0.0, 0.0, 0.0)


def to_nanoseconds(seconds: float) -> int:
    """Return a time of the robot's clock in ns; before zero, and where it is no number, zero."""
    return round(1e9 * seconds) if 0 < seconds < math.inf else 0


def to_timestamp(seconds: float) -> Timestamp:
    """Return a time as Foxglove has it."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(to_nanoseconds(seconds), 1_000_000_000))


def to_quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
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


def to_pose_message(pose: Pose) -> FoxglovePose:
    """Return a pose in the plane as one in space."""
    from foxglove.messages import Pose as FoxglovePose
    from foxglove.messages import Vector3

    position = Vector3(x=pose.x, y=pose.y, z=0.0)
    return FoxglovePose(position=position, orientation=to_quaternion(0.0, 0.0, pose.heading))


def build_transform(parent: str, child: str, pose: Pose, time: float) -> FrameTransform:
    """Return where a frame is in the plane of another."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(time),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=pose.x, y=pose.y, z=0.0),
        rotation=to_quaternion(0.0, 0.0, pose.heading),
    )


def build_mount_transform(device: str, mount: Mount) -> FrameTransform:
    """Return where a device sits on the body."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(0.0),
        parent_frame_id=BODY,
        child_frame_id=device,
        translation=Vector3(x=mount.x_m, y=mount.y_m, z=mount.z_m),
        rotation=to_quaternion(0.0, mount.pitch_rad, mount.yaw_rad),
    )


def build_optical_transform(device: str) -> FrameTransform:
    """Return how a camera's picture lies in its frame: x to the right, y down, z ahead (REP 103)."""
    from foxglove.messages import FrameTransform, Vector3

    return FrameTransform(
        timestamp=to_timestamp(0.0),
        parent_frame_id=device,
        child_frame_id=build_optical_name(device),
        translation=Vector3(),
        rotation=to_quaternion(-math.pi / 2, 0.0, -math.pi / 2),
    )


def build_optical_name(device: str) -> str:
    """Return the name of the frame that a camera's picture lies in."""
    return f"{device}_optical"


DEVICE = "device"
"""The key of a channel's metadata that names the device."""

RUN, TICKS, RESULT, END, TRUTH, LOG, POSE = "/run", "/ticks", "/result", "/end", "/truth", "/log", "/pose"
TRANSFORMS, STATIC_TRANSFORMS = "/tf", "/tf_static"
"""Apart, as ROS has them: who begins to look in the middle is given the last message of each channel."""

RESERVED = {RUN, TICKS, RESULT, END, TRUTH, LOG, POSE, TRANSFORMS, STATIC_TRANSFORMS}

RAYS = 9
"""As many as make an arc out of an ultrasonic sensor's cone."""

JPEG_QUALITY = 90

Write = Callable[[Any, float], None]
"""Logs a sample at a time of the robot's clock."""


def build_topic(device: str) -> str:
    """Return the topic of a device: its name, unless the run has a channel of that name."""
    topic = f"/{device}"
    return f"{topic}_device" if topic in RESERVED else topic


def open_channel(file: McapFile, device: Device, *, is_jpeg: bool) -> Write | None:
    """Return what logs a device's samples; None where it has none."""
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

    seen: Intrinsics = camera.intrinsics
    f, cx, cy = seen.focal_length, seen.cx, seen.cy
    message = CameraCalibration(
        timestamp=to_timestamp(0.0),
        frame_id=build_optical_name(camera.name),
        width=seen.width,
        height=seen.height,
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
    """Return a reading as an arc across the sensor's cone: the echo may have come from anywhere on it."""
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
