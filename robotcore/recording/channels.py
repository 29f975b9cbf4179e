"""The channels of a robot's devices: samples as Foxglove shows them. Each knows its device by its metadata."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import cv2

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
from robotcore.recording.frames import ORIGIN, nanoseconds, optical_name, planar, timestamp
from robotcore.recording.mcapfile import McapFile
from robotcore.recording.schemas import ANGLE, RANGE, VOLTAGE, Schema
from robotcore.recording.wire import to_json

if TYPE_CHECKING:
    from foxglove.messages import LaserScan

DEVICE = "device"
"""The key of a channel's metadata that names the device."""

RUN, TICKS, RESULT, END, TRUTH, LOG, POSE = "/run", "/ticks", "/result", "/end", "/truth", "/log", "/pose"
MOVING, MOUNTED = "/tf", "/tf_static"
"""Apart, as ROS has them: who begins to look in the middle is given the last message of each channel."""

RESERVED = {RUN, TICKS, RESULT, END, TRUTH, LOG, POSE, MOVING, MOUNTED}

RAYS = 9
"""As many as make an arc out of an ultrasonic sensor's cone."""

JPEG_QUALITY = 90

Write = Callable[[Any, float], None]
"""Logs a sample at a time of the robot's clock."""


def topic_of(device: str) -> str:
    """Return the topic of a device: its name, unless the run has a channel of that name."""
    topic = f"/{device}"
    return f"{topic}_device" if topic in RESERVED else topic


def writer_for(file: McapFile, device: Device, *, is_jpeg: bool) -> Write | None:
    """Return what logs a device's samples; None where it has none."""
    match device:
        case Camera():
            _calibrate(file, device)
            return _jpegs(file, device.name, optical_name(device.name)) if is_jpeg else _raw(file, device.name)
        case Display():
            shown = _jpegs(file, device.name, device.name)
            return lambda frame, at: shown(replace(frame, time=at), at)
        case RangeSensor():
            return _ranges(file, device)
        case Encoder():
            return _numbers(file, device.name, ANGLE)
        case Battery():
            return _numbers(file, device.name, VOLTAGE)
    return None


def _raw(file: McapFile, device: str) -> Write:
    from foxglove.channels import RawImageChannel
    from foxglove.messages import RawImage

    channel = RawImageChannel(topic_of(device), metadata={DEVICE: device}, context=file.context)

    def write(frame: Frame, at: float) -> None:
        image = frame.image
        message = RawImage(
            timestamp=timestamp(frame.time),
            frame_id=optical_name(device),
            width=image.shape[1],
            height=image.shape[0],
            encoding="bgr8" if image.ndim == 3 else "mono8",
            step=image[0].nbytes,
            data=image.tobytes(),
        )
        channel.log(message, log_time=nanoseconds(at))

    return write


def _jpegs(file: McapFile, device: str, frame_id: str) -> Write:
    from foxglove.channels import CompressedImageChannel
    from foxglove.messages import CompressedImage

    channel = CompressedImageChannel(topic_of(device), metadata={DEVICE: device}, context=file.context)

    def write(frame: Frame, at: float) -> None:
        message = CompressedImage(
            timestamp=timestamp(frame.time),
            frame_id=frame_id,
            format="jpeg",
            data=_jpeg(frame.image),
        )
        channel.log(message, log_time=nanoseconds(at))

    return write


def _jpeg(image: Image) -> bytes:
    _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return encoded.tobytes()


def _calibrate(file: McapFile, camera: Camera) -> None:
    from foxglove.channels import CameraCalibrationChannel
    from foxglove.messages import CameraCalibration

    seen: Intrinsics = camera.intrinsics
    f, cx, cy = seen.focal_length, seen.cx, seen.cy
    message = CameraCalibration(
        timestamp=timestamp(0.0),
        frame_id=optical_name(camera.name),
        width=seen.width,
        height=seen.height,
        K=[f, 0, cx, 0, f, cy, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0],
    )
    CameraCalibrationChannel(f"{topic_of(camera.name)}/calibration", context=file.context).log(message, log_time=0)


def _ranges(file: McapFile, sensor: RangeSensor) -> Write:
    from foxglove.channels import LaserScanChannel

    topic = topic_of(sensor.name)
    readings = file.json(topic, RANGE, {DEVICE: sensor.name})
    scans = LaserScanChannel(f"{topic}/scan", context=file.context)

    def write(reading: Range, at: float) -> None:
        readings(to_json(reading), nanoseconds(at))
        scans.log(_fan(sensor, reading), log_time=nanoseconds(at))

    return write


def _fan(sensor: RangeSensor, reading: Range) -> LaserScan:
    """Return a reading as an arc across the sensor's cone: the echo may have come from anywhere on it."""
    from foxglove.messages import LaserScan

    return LaserScan(
        timestamp=timestamp(reading.time),
        frame_id=sensor.name,
        pose=planar(ORIGIN),
        start_angle=-sensor.cone / 2,
        end_angle=sensor.cone / 2,
        ranges=[float(reading.distance)] * RAYS,
    )


def _numbers(file: McapFile, device: str, schema: Schema) -> Write:
    numbers = file.json(topic_of(device), schema, {DEVICE: device})

    def write(sample: Angle | Voltage, at: float) -> None:
        numbers(to_json(sample), nanoseconds(at))

    return write
