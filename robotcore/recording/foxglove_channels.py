"""The channels and the coordinate frames of a recording, in the messages of Foxglove."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import cv2

from robotcore.geometry import Pose
from robotcore.hal.device import Device, Sensor, build_driver_error
from robotcore.hal.kind import load_kind
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.display import Display
from robotcore.recording.channel_output import ChannelOutput
from robotcore.recording.codec import name_schema, to_json
from robotcore.recording.events import GroundTruthSample, Tick

if TYPE_CHECKING:
    from foxglove.messages import CompressedImage, FrameTransform, LaserScan, Quaternion, RawImage, Timestamp
    from foxglove.messages import Pose as FoxglovePose


ODOMETRY_FRAME, TRUTH_FRAME, BODY_FRAME = "odom", "truth", "base_link"
"""The coordinate frames: the start of the odometry, the world of a simulator, and the robot's body.

``odom`` and ``base_link`` are names of REP 105.
"""

TRUE_BODY_FRAME = f"{BODY_FRAME}_true"
"""The coordinate frame of the robot's body at its true pose."""


def to_nanoseconds(seconds: float) -> int:
    """Return a time in nanoseconds; 0 if it is negative, infinite or NaN."""
    return round(1e9 * seconds) if 0 < seconds < math.inf else 0


def to_timestamp(seconds: float) -> Timestamp:
    """Return Foxglove's message for a time in seconds."""
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(to_nanoseconds(seconds), 1_000_000_000))


def to_quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the quaternion of a rotation about x, then y, then z, in radians.

    Source: J. Diebel, Representing Attitude (2006), section 5.8.
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
    """Return Foxglove's message for a pose on the floor."""
    from foxglove import messages

    position = messages.Vector3(x=pose.x, y=pose.y, z=0.0)
    return messages.Pose(position=position, orientation=to_quaternion(0.0, 0.0, pose.heading))


def build_pose_transform(parent: str, child: str, pose: Pose, time: float) -> FrameTransform:
    """Return Foxglove's message for the pose of the frame ``child`` in the frame ``parent``, at a time in seconds."""
    return build_transform(parent, child, (pose.x, pose.y, 0.0), (0.0, 0.0, pose.heading), time)


def build_transform(
    parent: str, child: str, place: tuple[float, float, float], turn: tuple[float, float, float], time: float = 0.0
) -> FrameTransform:
    """Return Foxglove's message for a place in metres and a turn (roll, pitch, yaw) in radians."""
    from foxglove import messages

    x, y, z = place
    return messages.FrameTransform(
        timestamp=to_timestamp(time),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=messages.Vector3(x=x, y=y, z=z),
        rotation=to_quaternion(*turn),
    )


def build_optical_name(device: str) -> str:
    """Return the name of a camera's optical frame: x to the right, y down, z ahead (REP 103)."""
    return f"{device}_optical"


DEVICE = "device"
"""The key in a channel's metadata that has the name of its device."""

RUN, TICKS, RESULT, END, TRUTH, LOG, POSE = "/run", "/ticks", "/result", "/end", "/truth", "/log", "/pose"
TRANSFORMS, STATIC_TRANSFORMS = "/tf", "/tf_static"
"""The topics of moving and of fixed transforms, as in ROS."""

FRAMEWORK, APP = "robotcore", "app"
"""The sources of the lines in the text log: robotcore, and the prints of the app."""

RESERVED = {RUN, TICKS, RESULT, END, TRUTH, LOG, POSE, TRANSFORMS, STATIC_TRANSFORMS}

TICK_SCHEMA = name_schema("Tick", Tick)
TRUTH_SCHEMA = name_schema("Truth", GroundTruthSample)
RUN_SCHEMA = name_schema("Run", request=dict, devices=tuple[str, ...], started=str)
RESULT_SCHEMA = name_schema("Result", outcome=str, reason=str, exit_status=int, ticks=int)
END_SCHEMA = name_schema("End", reason=str)
"""The schemas of the JSON messages. A message leaves out empty fields, and has infinite numbers as strings."""

JPEG_QUALITY = 90

Write = Callable[[Any, float], None]
"""A function that writes a sample, at a time in seconds."""


def build_topic(device: str) -> str:
    """Return the topic of a device: its name, followed by ``_device`` if the topic is in `RESERVED`."""
    topic = f"/{device}"
    return f"{topic}_device" if topic in RESERVED else topic


def open_channel(output: ChannelOutput, device: Device, *, is_jpeg: bool, warn: Callable[[str], None]) -> Write | None:
    """Open the channels of a device, and return the function that writes its samples; None for a motor.

    is_jpeg: whether to write the pictures of a camera as JPEGs.
    warn: a function that receives a sentence about samples that cannot be shown.
    """
    match device:
        case Camera():
            return _open_images(output, device.name, build_optical_name(device.name), is_jpeg=is_jpeg)
        case Display():
            shown = _open_images(output, device.name, device.name, is_jpeg=True)
            return lambda frame, at: shown(replace(frame, time=at), at)
        case Sensor():
            return _open_rays(output, device, warn) if device.has_rays else _open_samples(output, device)
    return None


def _open_images(output: ChannelOutput, device: str, frame_id: str, *, is_jpeg: bool) -> Write:
    from foxglove.channels import CompressedImageChannel, RawImageChannel

    channel_type: Any = CompressedImageChannel if is_jpeg else RawImageChannel
    build_message = _build_jpeg if is_jpeg else _build_raw_image
    channel = channel_type(build_topic(device), metadata={DEVICE: device}, context=output.context)

    def write(frame: Frame, at: float) -> None:
        if channel.has_sinks():
            channel.log(build_message(frame, frame_id), log_time=to_nanoseconds(at))

    return write


def _build_raw_image(frame: Frame, frame_id: str) -> RawImage:
    from foxglove.messages import RawImage

    image = frame.image
    return RawImage(
        timestamp=to_timestamp(frame.time),
        frame_id=frame_id,
        width=image.shape[1],
        height=image.shape[0],
        encoding="bgr8" if image.ndim == 3 else "mono8",
        step=image[0].nbytes,
        data=image.tobytes(),
    )


def _build_jpeg(frame: Frame, frame_id: str) -> CompressedImage:
    from foxglove.messages import CompressedImage

    _, jpeg = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return CompressedImage(timestamp=to_timestamp(frame.time), frame_id=frame_id, format="jpeg", data=jpeg.tobytes())


def open_calibration(output: ChannelOutput, camera: Camera) -> Callable[[float], None]:
    """Open the channel of a camera's calibration, and return the function that writes it, at a time in seconds."""
    from foxglove.channels import CameraCalibrationChannel
    from foxglove.messages import CameraCalibration

    intrinsics = camera.intrinsics
    f, cx, cy = intrinsics.focal_length, intrinsics.cx, intrinsics.cy
    message = CameraCalibration(
        timestamp=to_timestamp(0.0),
        frame_id=build_optical_name(camera.name),
        width=intrinsics.width,
        height=intrinsics.height,
        distortion_model="plumb_bob" if intrinsics.distortion else "",
        D=list(intrinsics.distortion),
        K=[f, 0, cx, 0, f, cy, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0],
    )
    channel = CameraCalibrationChannel(f"{build_topic(camera.name)}/calibration", context=output.context)
    return lambda at: channel.log(message, log_time=to_nanoseconds(at))


def _open_rays(output: ChannelOutput, sensor: Sensor[Any], warn: Callable[[str], None]) -> Write:
    """Open the channels of the samples and of scans. A kind whose rays cannot be listed gets no further scans."""
    from foxglove.channels import LaserScanChannel

    write_sample = _open_samples(output, sensor)
    scans = LaserScanChannel(f"{build_topic(sensor.name)}/scan", context=output.context)
    has_failed = False

    def write(sample: Any, at: float) -> None:
        nonlocal has_failed
        write_sample(sample, at)
        if has_failed:
            return
        try:
            scan = _build_scan(sensor, sample)
        except Exception as error:  # noqa: BLE001  the sensor may be of another package
            has_failed = True
            warn(f"the recording has no rays of {build_driver_error(sensor.name, error)}. Correct the kind's list_rays")
            return
        scans.log(scan, log_time=to_nanoseconds(at))

    return write


def _build_scan(sensor: Sensor[Any], sample: Any) -> LaserScan:
    from foxglove.messages import LaserScan

    rays = sensor.list_rays(sample)
    return LaserScan(
        timestamp=to_timestamp(sample.time),
        frame_id=sensor.name,
        pose=to_pose_message(Pose(0.0, 0.0, 0.0)),
        start_angle=rays.start,
        end_angle=rays.end,
        ranges=list(rays.distances),
    )


def _open_samples(output: ChannelOutput, sensor: Sensor[Any]) -> Write:
    sample: Any = load_kind(sensor.kind).sample
    schema = name_schema(sample.__name__, sample)
    write = output.open_json_channel(build_topic(sensor.name), schema, {DEVICE: sensor.name})
    return lambda sample, at: write(to_json(sample), to_nanoseconds(at))
