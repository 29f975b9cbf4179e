"""The channels of a recording, read by the reader of the MCAP library."""

from __future__ import annotations

import json
import math
import struct
from collections import Counter

import pytest
from mcap.reader import make_reader

from robotcore.kinds.range_sensor import Range
from robotcore.recording.codec import name_schema, read_fields
from robotcore.recording.foxglove_channels import RUN_SCHEMA, TICK_SCHEMA, to_nanoseconds, to_quaternion
from tests.robotcore.recording.conftest import RecordedRun

SCHEMAS = {
    "/eye": "foxglove.RawImage",
    "/eye/calibration": "foxglove.CameraCalibration",
    "/log": "foxglove.Log",
    "/left_encoder": "robotcore.Angle",
    "/nose": "robotcore.Range",
    "/nose/scan": "foxglove.LaserScan",
    "/pose": "foxglove.PoseInFrame",
    "/result": "robotcore.Result",
    "/right_encoder": "robotcore.Angle",
    "/run": "robotcore.Run",
    "/screen": "foxglove.CompressedImage",
    "/tf": "foxglove.FrameTransforms",
    "/tf_static": "foxglove.FrameTransforms",
    "/ticks": "robotcore.Tick",
    "/truth": "robotcore.Truth",
}


def test_every_channel_has_its_foxglove_schema_and_every_frame(recorded: RecordedRun) -> None:
    with recorded.file.open("rb") as file:
        messages = list(make_reader(file, validate_crcs=True).iter_messages())
    assert {channel.topic: schema.name for schema, channel, _ in messages if schema} == SCHEMAS
    last = {channel.topic: message.data for _, channel, message in messages}
    frames = {frame: parent for topic in ("/tf", "/tf_static") for parent, frame in decode_transforms(last[topic])}
    assert frames == {
        "base_link": "odom",
        "base_link_true": "truth",
        "odom": "truth",
        "nose": "base_link",
        "eye": "base_link",
        "eye_optical": "eye",
    }


def decode_transforms(message: bytes) -> list[tuple[str, str]]:
    """Return the parent and child of each transform (FrameTransforms.proto, FrameTransform.proto)."""
    transforms = [dict(read_fields(bytes(each))) for _, each in read_fields(message)]
    return [(bytes(each[2]).decode(), bytes(each[3]).decode()) for each in transforms]


def test_file_has_descriptions_app_and_request_and_each_picture_once(recorded: RecordedRun) -> None:
    kept = [key for key in recorded.witness.samples if key.device == "eye"]
    with recorded.file.open("rb") as file:
        reader = make_reader(file)
        counts = Counter(channel.topic for _, channel, _ in reader.iter_messages())
        attached = {each.name: each.data for each in reader.iter_attachments()}
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
    assert counts["/eye"] == len(kept) < counts["/ticks"]
    assert attached.keys() == {"robot.json", "world.json", "app.py"}
    assert json.loads(attached["robot.json"])["name"] == "rover"
    assert metadata["robotcore.run"]["backend"] == "kinematic"
    assert metadata["robotcore.result"]["outcome"] == "success"


def test_schemas_have_the_fields_of_the_events_and_their_simple_types() -> None:
    wheels = {"type": "object", "properties": {"left": {"type": "number"}, "right": {"type": "number"}}}
    tick = TICK_SCHEMA["properties"]
    assert (TICK_SCHEMA["title"], tick["sent"]) == ("robotcore.Tick", wheels)
    assert tick["warnings"] == {"type": "array", "items": {"type": "string"}}
    assert tick["reads"]["items"]["properties"]["number"] == {"type": "integer"}
    assert tick["error"]["properties"]["attributes"] == {"type": "object", "properties": {}}
    assert name_schema("Range", Range)["properties"]["point"] == {"type": "array", "items": {"type": "number"}}
    assert list(RUN_SCHEMA["properties"]) == ["request", "devices", "started"]


def test_optical_frame_looks_ahead() -> None:
    """The optical z axis is the camera's x (ahead), the optical x axis is the camera's -y (to the right)."""
    turn = to_quaternion(-math.pi / 2, 0.0, -math.pi / 2)
    x, y, z, w = (struct.unpack("<d", value)[0] for _, value in read_fields(turn.encode()))
    ahead = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    right = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    assert ahead == pytest.approx((1, 0, 0))
    assert right == pytest.approx((0, -1, 0))


@pytest.mark.parametrize("seconds, whole", [(0.05, 50_000_000), (-1.0, 0), (math.nan, 0), (math.inf, 0)])
def test_negative_and_non_finite_times_become_zero(seconds: float, whole: int) -> None:
    assert to_nanoseconds(seconds) == whole
