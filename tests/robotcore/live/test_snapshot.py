from __future__ import annotations

import json
import math
from typing import Any

import pytest

from robotcore import Pose, run
from robotcore.geometry import Wheels
from robotcore.kinds.encoder import Angle
from robotcore.kinds.lidar import Scan
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.live.messages import encode, to_json
from robotcore.live.run_description import describe_run, find_grid
from robotcore.live.snapshot import MAX_RAYS, Snapshot, SnapshotBuilder, WheelSpeeds, describe_sample
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.request import RunRequest
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord
from tests.robotcore.live.live_run import Circles
from tests.robotcore.runs import Watcher


class Snapper(Watcher):
    """Takes a snapshot in each tick."""

    def begin(self, run: RunContext) -> None:
        super().begin(run)
        self.builder, self.snapshots = SnapshotBuilder(run), list[Snapshot]()
        self.description = describe_run(run)

    def tick(self, record: TickRecord) -> None:
        self.snapshots.append(self.builder.take(record))


def take(**request: Any) -> Snapper:
    snapper = Snapper()
    fields = {"app": Circles, "world": "open", "timeout_s": 0.5, **request}
    run(RunRequest(**fields), [snapper])
    return snapper


def test_a_snapshot_reads_no_device_and_changes_no_run() -> None:
    request = RunRequest(Circles, world="arena", timeout_s=0.5)
    assert run(request, [Snapper()]).trace_sha256 == run(request).trace_sha256


def test_a_message_has_the_values_of_its_tick() -> None:
    snapper = take()
    message = snapper.builder.build_message(snapper.snapshots[4], ["range guard"])
    encode(message)
    assert (message["tick"], message["state"], message["interventions"]) == (4, "turning", ["range guard"])
    assert message["milestones"] == {"turning": 0.0}
    assert message["logged"]["gap"]["unit"] == "m"
    assert message["devices"]["left_motor"]["values"]["command"] == pytest.approx(message["sent"][0])
    assert message["devices"]["nose"]["age"] == 0.0


def test_each_point_of_the_path_is_sent_once() -> None:
    snapper = take()
    first = snapper.builder.build_message(snapper.snapshots[-1], [])["path"]
    assert len(first) > 2
    start = snapper.snapshots[0].truth
    assert start
    assert first[0] == (start.x, start.y, "turning")
    assert snapper.builder.build_message(snapper.snapshots[-1], [])["path"] == []


def test_the_pictures_are_those_of_displays_before_those_of_cameras() -> None:
    snapper = take()
    assert [name for name, _ in snapper.builder.list_pictures(snapper.snapshots[-1])] == ["screen", "eye"]


def test_the_description_is_json_and_names_each_device_of_the_run() -> None:
    snapper = take(app="avoid-obstacles")
    description = json.loads(encode(snapper.description))
    assert {each["name"] for each in description["devices"]} == {*snapper.calls[0][1].robot.devices}
    assert description["is_simulated"]
    assert description["bounds"][2] > 3.0


def test_a_number_that_json_lacks_is_null() -> None:
    assert to_json({"a": (math.nan, math.inf, 1), "b": True, "c": object}) == {
        "a": [None, None, 1],
        "b": True,
        "c": str(object),
    }


def test_the_rays_of_a_large_scan_are_thinned() -> None:
    scan = Scan((1.0,) * 4000, 0.0, 0)

    class Lidar:
        has_rays, mount = True, Pose(0.0, 0.0, 0.0)

        def format_sample(self, sample: Scan) -> str:
            return "4000 rays"

        def list_rays(self, sample: Scan) -> tuple[float, float, tuple[float, ...]]:
            return -1.0, 1.0, sample.distances

    lidar: Any = Lidar()
    described = describe_sample(lidar, scan, 1.0)
    assert len(described["rays"]["distances"]) == MAX_RAYS
    assert described["values"] == {}
    assert described["age"] == 1.0


def test_a_sample_whose_numbers_json_lacks_has_none_in_their_place() -> None:
    class Lidar:
        has_rays, mount = True, Pose(0.0, 0.0, 0.0)

        def format_sample(self, sample: Scan) -> str:
            return "a damaged scan"

        def list_rays(self, sample: Scan) -> tuple[float, float, tuple[float, ...]]:
            return -math.inf, math.nan, sample.distances

    lidar: Any = Lidar()
    described = describe_sample(lidar, Scan((1.0,), -math.inf, 0), 1.0)
    assert encode(described)
    assert described["age"] is None
    assert described["rays"] == {"start": None, "end": None, "distances": [1.0]}


def test_a_kind_that_raises_has_the_exception_as_its_text(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(sensor: object, sample: object) -> str:
        raise ZeroDivisionError("a kind of another package")

    snapper = take()
    monkeypatch.setattr(RangeSensor, "format_sample", fail)
    devices = snapper.builder.build_message(snapper.snapshots[-1], [])["devices"]
    assert "ZeroDivisionError: a kind of another package" in devices["nose"]["text"]
    assert devices["eye"]["text"] == "320x240 pixels"


@pytest.mark.slow
def test_the_pace_the_overruns_and_the_person_are_in_the_message() -> None:
    snapper = take(has_operator=True, realtime=True)
    message = snapper.builder.build_message(snapper.snapshots[-1], [])
    assert message["pace"] == {"speed": 1.0, "is_paused": False}
    assert message["is_hand_driven"] is False
    assert message["overruns"] >= 0
    context = snapper.calls[0][1]
    context.operator.drive(0.1, 0.0)
    context.pace.pause()
    message = snapper.builder.build_message(snapper.snapshots[-1], [])
    assert message["pace"]["is_paused"]
    assert message["is_hand_driven"] is True


def test_wheel_speeds_are_measured_over_a_tenth_of_a_second_and_need_encoders() -> None:
    assert WheelSpeeds([], []).measure({}) is None
    speeds = WheelSpeeds(["left"], ["right"])
    assert speeds.measure({}) is None
    measured = [
        speeds.measure({"left": Angle(tick * 0.01, tick * 0.01, tick), "right": Angle(0.0, tick * 0.01, tick)})
        for tick in range(30)
    ]
    assert measured[0] is None
    assert measured[-1] == pytest.approx(Wheels(1.0, 0.0))
    again = speeds.measure({"left": Angle(9.0, 0.29, 29), "right": Angle(9.0, 0.29, 29)})
    assert again == measured[-1], "an old sample changes nothing"


def test_only_an_occupancy_grid_is_a_map() -> None:
    app = Behaviour()
    app.grid = "a list of rows"  # type: ignore[attr-defined]
    assert find_grid(app) is None
