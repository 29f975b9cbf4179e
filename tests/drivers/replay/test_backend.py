from __future__ import annotations

from dataclasses import replace
from itertools import accumulate
from typing import Any

import pytest

from drivers.replay.backend import ReplayBackend
from drivers.replay.devices import ReplayClock
from robotcore.description import load_robot
from robotcore.errors import DeviceError, RecordingEndedError, UnmetNeedError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.range_sensor import Range
from robotcore.recording import Metadata, Read, RecordedError, Recording, SampleKey, Tick
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import run
from tests.texts import Raises

ROVER = load_robot("rover")
EVERY = tuple(device.name for device in ROVER.devices)
FIRST, SECOND = Range(0.1 + 0.2, 0.0, 4), Range(float("inf"), 0.1, 5)
FAILED = Read("nose", error=RecordedError.from_error(DeviceError("nose", "no echo")))
READS = [
    (),
    (Read("nose", 4, 0.0, 0),),
    (),
    (FAILED, Read("nose", 5, 0.1, 1)),
    (FAILED,),
]


def build_recording(devices: tuple[str, ...] = EVERY, reads: list[Any] | None = None) -> Recording:
    ticks = [Tick(at, at / 20, "search", given) for at, given in enumerate(READS if reads is None else reads)]
    samples = {SampleKey("nose", 0): FIRST, SampleKey("nose", 1): SECOND}
    about = Metadata(RunRequest("green-search"), ROVER, is_stepped=True, devices=devices)
    return Recording(about, ticks, samples)


def open_robot(recorded: Recording, *devices: str, **more: Any) -> Robot:
    return ReplayBackend().open(Setup(ROVER, None, frozenset(devices), options={"recording": recorded}, **more))


def test_reads_of_a_tick_keep_their_order_and_the_last_one_is_repeated() -> None:
    expected: list[list[Range | None]] = [[None], [FIRST], [FIRST], [None, SECOND, SECOND], [None, None]]
    robot = open_robot(build_recording(), "nose")
    for tick, samples in enumerate(expected):
        for sample in samples:
            if sample:
                assert robot.range.read() is sample
                continue
            with pytest.raises(DeviceError) as caught:
                robot.range.read()
            assert caught.value.device == "nose"
            assert (caught.value.kind == "no-sample-yet") == (tick == 0)
        if tick < len(expected) - 1:
            robot.clock.sleep_until(robot.clock.now() + 0.05)


def test_dropped_sample_is_replaced_by_the_newest_earlier_one() -> None:
    dropped = Read("nose", 7, 0.05, None)
    robot = open_robot(
        build_recording(reads=[(Read("nose", 4, 0.0, 0),), (dropped,), (Read("nose", 8, 0.1, 9),)]), "nose"
    )
    for _ in range(2):
        robot.clock.sleep_until(robot.clock.now() + 0.05)
        assert robot.range.read() is FIRST


def test_unfitting_requests_are_refused(raises: Raises) -> None:
    with raises(UnmetNeedError, "not-recorded", devices=["eye"], opened=["nose"]):
        open_robot(build_recording(("nose",)), "eye", "nose", "left_motor", "screen")
    with raises(UsageError, "replay-rate", rate_hz=10.0, recorded_hz=20.0):
        open_robot(build_recording(), "nose", rate_hz=10.0)
    with raises(UsageError, "replay-robot", robot="lookout", recorded="rover"):
        ReplayBackend().load_robot("lookout", {"recording": build_recording()})
    with raises(UsageError, "no-recording"):
        ReplayBackend().load_robot("rover", {})
    with pytest.raises(UsageError, match="option recording"):
        ReplayBackend().open(Setup(ROVER, None, frozenset(), options={"recording": "run.mcap"}))


def test_recorded_robot_is_described_by_the_recording() -> None:
    own = ROVER.model_copy(update={"name": "own"})
    recorded = build_recording()
    recorded = replace(recorded, metadata=replace(recorded.metadata, description=own))
    assert ReplayBackend().load_robot("rover", {"recording": recorded, "keeps_safety_rules": True}) is own
    served = ReplayBackend().load_robot("rover", {"recording": recorded})
    assert served.model_copy(update={"safety": own.safety}) == own
    assert min(served.safety.follow_s, served.safety.max_age_s) > recorded.ticks[-1].time


def test_app_runs_until_the_recording_ends() -> None:
    steady = [(Read("nose", 4, 0.0, 0),)] * 5
    result = run(RunRequest("avoid-obstacles", "replay", options={"recording": build_recording(reads=steady)}))
    assert (result.outcome, result.exit_status, result.verified) == (Outcome.ERROR, 3, None)


@pytest.mark.parametrize(
    "times, deadlines, ticks, are_ahead",
    [
        ([0.0, 0.31, 0.35], [0.05], [1], [True]),
        ([0.0, 0.4, 0.4], [0.05, 0.1], [1, 2], [True, False]),
        ([0.0, 0.05, 0.1, 0.15], [0.1], [2], [True]),
        ([0.0, 0.05, 0.1, 3 * 0.05], [0.15], [3], [True]),
        ([tick / 20 for tick in range(200)], list(accumulate([0.05] * 199)), list(range(1, 200)), [True] * 199),
    ],
)
def test_sleep_advances_by_at_least_a_tick_to_the_last_one_before_its_deadline(
    times: list[float], deadlines: list[float], ticks: list[int], are_ahead: list[bool]
) -> None:
    clock = ReplayClock(times)
    assert [(clock.sleep_until(deadline), clock.tick, clock.now()) for deadline in deadlines] == [
        (is_ahead, tick, times[tick]) for tick, is_ahead in zip(ticks, are_ahead, strict=True)
    ]


def test_sleep_after_the_last_tick_raises_an_error(raises: Raises) -> None:
    clock = ReplayClock([0.0, 0.05])
    clock.sleep_until(0.05)
    with raises(RecordingEndedError, ticks=2, time_s=0.05):
        clock.sleep_until(0.1)


def test_calls_are_made_in_order_at_their_time() -> None:
    clock = ReplayClock([0.0, 0.1, 0.2])
    made: list[tuple[str, float]] = []
    clock.call_at(0.08, lambda: made.append(("second", clock.now())))
    clock.call_at(0.03, lambda: made.append(("first", clock.now())))
    clock.call_at(0.15, lambda: made.append(("third", clock.now())))
    clock.sleep_until(0.1)
    assert made == [("first", 0.03), ("second", 0.08)]
    assert clock.now() == 0.1
    clock.close()
    clock.sleep_until(0.2)
    assert len(made) == 2
