from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from drivers.replay.backend import ReplayBackend
from drivers.replay.devices import ReplayClock
from robotcore.description import load_robot
from robotcore.errors import DeviceError, RecordingEndedError, UnmetNeedError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.recording import Metadata, Read, RecordedError, Recording, SampleKey, Tick
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import run
from tests.texts import Raises

ROVER = load_robot("rover")
EVERY = tuple(device.name for device in ROVER.devices)
FIRST, SECOND = Range(0.1 + 0.2, 0.0, 4), Range(float("inf"), 0.1, 5)
FAILED = Read("nose", error=RecordedError.of(DeviceError("nose", "no echo")))
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


def open_at_tick(tick: int) -> tuple[Robot, RangeSensor]:
    robot = open_robot(build_recording(), "nose")
    for _ in range(tick):
        robot.clock.sleep_until(robot.clock.now() + 0.05)
    return robot, robot.range


def test_sample_is_bitwise_equal() -> None:
    _, nose = open_at_tick(1)
    assert nose.read() == FIRST


def test_read_before_the_first_sample_fails(raises: Raises) -> None:
    _, nose = open_at_tick(0)
    with raises(DeviceError, "no-sample-yet", device="nose"):
        nose.read()


def test_read_without_an_earlier_read_returns_the_newest_earlier_sample() -> None:
    _, nose = open_at_tick(2)
    assert nose.read() is FIRST


def test_reads_keep_their_order_and_the_last_one_is_repeated(raises: Raises) -> None:
    _, nose = open_at_tick(3)
    with raises(DeviceError, device="nose"):
        nose.read()
    assert [nose.read(), nose.read()] == [SECOND, SECOND]


def test_recorded_error_is_raised_at_each_read(raises: Raises) -> None:
    _, nose = open_at_tick(4)
    for _ in range(2):
        with raises(DeviceError, device="nose"):
            nose.read()


def test_dropped_sample_is_replaced_by_the_newest_earlier_one() -> None:
    dropped = Read("nose", 7, 0.05, None)
    robot = open_robot(
        build_recording(reads=[(Read("nose", 4, 0.0, 0),), (dropped,), (Read("nose", 8, 0.1, 9),)]), "nose"
    )
    for _ in range(2):
        robot.clock.sleep_until(robot.clock.now() + 0.05)
        assert robot.range.read() is FIRST


def test_unrecorded_sensor_is_refused(raises: Raises) -> None:
    with raises(UnmetNeedError, "not-recorded", devices=["eye"], opened=["nose"]):
        open_robot(build_recording(("nose",)), "eye", "nose")


def test_motors_and_displays_need_no_recording() -> None:
    with open_robot(build_recording(("nose",)), "left_motor", "screen") as robot:
        assert set(robot.devices) == {"left_motor", "screen"}


def test_other_rate_is_refused(raises: Raises) -> None:
    with raises(UsageError, "replay-rate", rate_hz=10.0, recorded_hz=20.0):
        open_robot(build_recording(), "nose", rate_hz=10.0)


def test_other_robot_is_refused(raises: Raises) -> None:
    with raises(UsageError, "replay-robot", robot="lookout", recorded="rover"):
        ReplayBackend().load_robot("lookout", {"recording": build_recording()})


def test_missing_file_option_is_refused(raises: Raises) -> None:
    with raises(UsageError, "no-recording"):
        ReplayBackend().load_robot("rover", {})


def test_text_as_recording_is_refused() -> None:
    with pytest.raises(UsageError, match="option recording"):
        ReplayBackend().open(Setup(ROVER, None, frozenset(), options={"recording": "run.mcap"}))


def test_recorded_robot_is_described_by_the_recording() -> None:
    own = ROVER.model_copy(update={"name": "own"})
    recorded = build_recording()
    recorded = replace(recorded, metadata=replace(recorded.metadata, description=own))
    assert ReplayBackend().load_robot("rover", {"recording": recorded, "is_held": True}) is own
    served = ReplayBackend().load_robot("rover", {"recording": recorded})
    assert served.model_copy(update={"safety": own.safety}) == own
    assert min(served.safety.follow_s, served.safety.max_age_s) > recorded.ticks[-1].time


def test_app_runs_until_the_recording_ends() -> None:
    steady = [(Read("nose", 4, 0.0, 0),)] * 5
    result = run(RunRequest("avoid-obstacles", "replay", options={"recording": build_recording(reads=steady)}))
    assert (result.outcome, result.exit_status, result.verified) == (Outcome.ERROR, 3, None)


def test_sleep_advances_to_a_late_tick() -> None:
    clock = ReplayClock([0.0, 0.31, 0.35])
    assert clock.sleep_until(0.05)
    assert clock.now() == 0.31


def test_deadline_that_is_a_sum_of_periods_skips_no_tick() -> None:
    times = [tick / 20 for tick in range(200)]
    clock, deadline = ReplayClock(times), 0.0
    for time in times[1:]:
        deadline += 0.05
        clock.sleep_until(deadline)
        assert clock.now() == time


def test_sleep_with_a_past_deadline_advances_and_returns_false() -> None:
    clock = ReplayClock([0.0, 0.4, 0.4])
    clock.sleep_until(0.05)
    assert not clock.sleep_until(0.1)
    assert (clock.now(), clock.tick) == (0.4, 2)


def test_sleep_advances_to_its_deadline() -> None:
    clock = ReplayClock([0.0, 0.05, 0.1, 0.15])
    clock.sleep_until(0.1)
    assert clock.tick == 2


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


def test_closed_clock_makes_no_calls() -> None:
    clock = ReplayClock([0.0, 0.1])
    made: list[float] = []
    clock.call_at(0.05, lambda: made.append(clock.now()))
    clock.close()
    clock.sleep_until(0.1)
    assert not made


def test_rounding_error_of_a_deadline_skips_no_tick() -> None:
    clock = ReplayClock([0.0, 0.05, 0.1, 3 * 0.05])
    assert 3 * 0.05 > 0.15
    clock.sleep_until(0.15)
    assert clock.tick == 3
