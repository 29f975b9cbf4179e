"""Verification of recordings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from robotcore.errors import EmergencyStopError, Interrupted, RecordingError
from robotcore.geometry import Wheels
from robotcore.recording import RecordedError, Recording, Tick
from robotcore.recording.replay import replay
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety import Intervention
from tests.robotcore.recording.replay.disturbances import (
    Disturbance,
    EmergencyStopBetween,
    EmergencyStopInTick,
    SignalBetween,
    SignalInTick,
)
from tests.robotcore.recording.replay.memory import change_tick, record_run
from tests.texts import Raises

APPS = str(Path(__file__).parent / "recorded_apps.py")
ACTIONS = [
    "succeed",
    "fail",
    "go_on",
    "divide",
    "command_nan",
    "swallow_nan",
    "rename_nan",
    "stop_and_go",
    "command_one_wheel",
]


def record_final_action(action: str = "succeed", **asked: Any) -> Recording:
    settings = {"action": action, "speed": 0.35}
    return record_run(f"{APPS}:FinalActionApp", settings=settings, **{"seed": 3, "timeout_s": 6.0, **asked})


def require_equal(recording: Recording) -> None:
    replayed, result = replay(recording), get_result(recording)
    assert replayed.deviation is None
    assert (replayed.ticks, replayed.is_exact) == (len(recording.ticks), True)
    assert replayed.trace_sha256 == result.trace_sha256
    assert replayed.exit_status == 0
    if not replayed.ended_by:
        assert replayed.result.outcome is result.outcome


def get_result(recording: Recording) -> RunResult:
    assert recording.result
    return recording.result


@pytest.mark.parametrize("action", ACTIONS)
def test_run_with_any_end_is_replayed_bit_equal(action: str) -> None:
    require_equal(record_final_action(action))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "pybullet"])
@pytest.mark.parametrize(
    "faults",
    [
        ("camera drop=0.3", "range noise=0.1"),
        ("nose freeze after=0.3",),
        ("connection lost=0.5 after=0.6",),
        ("left_motor dead after=0.4",),
        ("loop stall=0.3 every=0.7",),
        ("encoders slip=0.3", "camera delay=0.2"),
    ],
)
def test_injected_faults_are_replayed(backend: str, faults: tuple[str, ...]) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    recording = record_run(f"{APPS}:IntermittentApp", backend=backend, seed=5, timeout_s=4.0, faults=faults)
    require_equal(recording)


def test_stale_encoders_are_replayed() -> None:
    recording = record_final_action("go_on", faults=("encoders freeze after=0.5",))
    assert recording.ticks[-1].turned[0].error
    require_equal(recording)


def test_pose_without_encoders_is_computed_from_the_recorded_angles(tmp_path: Path) -> None:
    robot = tmp_path / "blind.toml"
    rover = resources.files("robotcore.description").joinpath("robots/rover.toml").read_text()
    parts = [part for part in rover.split("\n\n") if 'kind = "encoder"' not in part]
    robot.write_text("\n".join(line for line in "\n\n".join(parts).split("\n") if "_encoder =" not in line))
    recording = record_final_action("command_one_wheel", robot=str(robot))
    assert "left_encoder" not in recording.metadata.devices
    robot.unlink()
    require_equal(recording)


def test_green_search_is_replayed_bit_equal() -> None:
    require_equal(record_run("green-search", seed=7, timeout_s=8.0))


def test_object_addresses_in_a_reason_are_ignored() -> None:
    recording = record_run(f"{APPS}:CameraApp", robot="lookout", world="open", seed=3)
    assert "0x" in get_result(recording).reason
    require_equal(recording)


def test_line_numbers_in_an_error_are_ignored() -> None:
    recording = record_final_action("command_nan")
    last = recording.ticks[-1].error
    assert last
    assert ", at recorded_apps.py:" in last.message
    moved = replace(last, message=re.sub(r"recorded_apps\.py:\d+", "before.py:7", last.message))
    require_equal(change_tick(recording, len(recording.ticks) - 1, error=moved))


def test_other_message_of_the_same_error_is_the_same_end() -> None:
    recording = record_final_action("command_nan")
    last = recording.ticks[-1].error
    assert last
    require_equal(change_tick(recording, len(recording.ticks) - 1, error=replace(last, message="in other words")))


def test_other_class_or_attribute_of_an_error_is_another_end() -> None:
    recording = record_run("avoid-obstacles", seed=3, timeout_s=6.0, faults=("range freeze after=1",))
    last = recording.ticks[-1].error
    assert last
    assert last.attributes["device"] == "nose"
    for error in (replace(last, kind="DeviceError"), replace(last, attributes={**last.attributes, "device": "eye"})):
        assert replay(change_tick(recording, len(recording.ticks) - 1, error=error)).deviation


def test_signal_within_a_tick_ends_the_replay_before_this_tick() -> None:
    whole = record_final_action("go_on")
    ticks = whole.ticks[:20]
    result = replace(get_result(whole), outcome=Outcome.INTERRUPTED, reason="interrupted by SIGTERM", ticks=20)
    cut = change_tick(replace(whole, ticks=ticks, result=result), 19, asks=(), error=RecordedError.of(Interrupted(15)))
    replayed = replay(cut)
    assert (replayed.deviation, replayed.ticks, replayed.exit_status) == (None, 19, 0)
    assert replayed.ended_by == "interrupted by SIGTERM"


def test_signal_between_ticks_ends_the_replay_after_the_last_tick() -> None:
    whole = record_final_action("go_on")
    result = replace(get_result(whole), outcome=Outcome.INTERRUPTED, reason="interrupted by SIGINT", ticks=20)
    replayed = replay(replace(whole, ticks=whole.ticks[:20], result=result))
    assert (replayed.deviation, replayed.ticks, replayed.ended_by) == (None, 20, "interrupted by SIGINT")


def test_cut_recording_is_replayed_up_to_its_last_tick() -> None:
    whole = record_final_action("go_on")
    replayed = replay(replace(whole, ticks=whole.ticks[:20], result=None, is_cut=True))
    assert (replayed.deviation, replayed.ticks, replayed.ended_by) == (
        None,
        20,
        "the file was cut before the run ended",
    )


def test_death_of_the_simulator_ends_the_replay_in_the_same_tick() -> None:
    whole = record_final_action("go_on")
    result = replace(get_result(whole), outcome=Outcome.ERROR, reason="the simulator has died", ticks=20)
    replayed = replay(replace(whole, ticks=whole.ticks[:20], result=result))
    assert (replayed.deviation, replayed.ended_by) == (None, "the simulator has died")


def test_recording_that_cannot_be_replayed_is_refused(raises: Raises) -> None:
    with raises(RecordingError, "recording-not-replayable", file="run.mcap"):
        replay(replace(record_final_action(), missing_inputs="the pictures of eye are JPEGs"), "run.mcap")


def test_recording_without_a_tick_is_refused(raises: Raises) -> None:
    with raises(RecordingError, "recording-without-tick"):
        replay(replace(record_final_action(), ticks=[]))


def test_wrong_digest_is_reported() -> None:
    recording = record_final_action()
    forged = replace(recording, result=replace(get_result(recording), trace_sha256="0" * 64))
    replayed = replay(forged)
    assert (replayed.deviation, replayed.is_equal, replayed.exit_status) == (None, False, 1)


def test_small_difference_on_another_machine_counts_as_equal() -> None:
    recording = change_platform(change_command(record_final_action(), 3, 1e-12))
    replayed = replay(recording)
    assert (replayed.deviation, replayed.is_exact, replayed.exit_status) == (None, False, 0)
    assert 0 < replayed.largest_difference < 1e-11
    assert any("numpy" in line for line in replayed.platform)


def test_large_difference_on_another_machine_is_a_deviation() -> None:
    deviation = replay(change_platform(change_command(record_final_action(), 3, 1e-6))).deviation
    assert deviation
    assert deviation.tick == 3


def test_any_difference_on_this_machine_is_a_deviation() -> None:
    deviation = replay(change_command(record_final_action(), 3, 1e-15)).deviation
    assert deviation
    assert deviation.tick == 3


def change_command(recording: Recording, number: int, by: float) -> Recording:
    """Return the recording with one slightly faster command."""
    tick = recording.ticks[number]
    (ask,) = tick.asks
    assert ask.asked
    asked = ask.asked._replace(left=ask.asked.left + by)
    assert asked != ask.asked
    return change_tick(recording, number, asks=(replace(ask, asked=asked),), asked=asked)


def change_platform(recording: Recording) -> Recording:
    platform = {**recording.metadata.platform, "machine": "riscv64", "numpy": "1.24.0"}
    return replace(recording, metadata=replace(recording.metadata, platform=platform))


@pytest.mark.parametrize("kind", [EmergencyStopBetween, EmergencyStopInTick, SignalBetween, SignalInTick])
@pytest.mark.parametrize("app", ["avoid-obstacles", f"{APPS}:CameraApp", f"{APPS}:IntermittentApp"])
def test_external_stop_ends_the_replay_in_the_same_tick(kind: type[Disturbance], app: str) -> None:
    recording = record_run(app, disturbance=kind(6), seed=2, timeout_s=2.0)
    assert get_result(recording).outcome in (Outcome.STOPPED, Outcome.INTERRUPTED)
    replayed = replay(recording)
    cut_short = kind is SignalInTick and len(recording.ticks) == 7
    assert (replayed.deviation, replayed.ticks) == (None, len(recording.ticks) - cut_short)
    assert replayed.exit_status == 0
    if kind in (EmergencyStopBetween, EmergencyStopInTick):
        assert (replayed.result.outcome, replayed.result.reason) == (Outcome.STOPPED, get_result(recording).reason)
        assert replayed.trace_sha256 == get_result(recording).trace_sha256


def test_stop_after_the_commands_of_a_tick_does_not_change_them() -> None:
    whole = record_final_action("go_on")
    pressed = RecordedError.of(EmergencyStopError("the button was pressed"))
    cut = Intervention(1.0, "e-stop", Wheels(1.0, 1.0), Wheels(0.0, 0.0))
    result = replace(
        get_result(whole), outcome=Outcome.STOPPED, ticks=20, trace_sha256=compute_digest(whole.ticks[:20])
    )
    late = change_tick(replace(whole, ticks=whole.ticks[:20], result=result), 19, error=pressed, interventions=(cut,))
    replayed = replay(late)
    assert (replayed.deviation, replayed.ticks, replayed.exit_status) == (None, 20, 0)
    assert (replayed.result.outcome, replayed.result.ticks) == (Outcome.STOPPED, 20)


def compute_digest(ticks: Sequence[Tick]) -> str:
    trace = Trace(())
    for tick in ticks:
        trace.add(TickRecord(tick.number, tick.time, tick.state, tick.asked, tick.sent, ()))
    return trace.sha256


def test_hang_of_the_app_ends_the_replay_before_this_tick() -> None:
    whole = record_final_action("go_on")
    cut = Intervention(1.0, "watchdog", Wheels(1.0, 1.0), Wheels(0.0, 0.0))
    result = replace(get_result(whole), outcome=Outcome.STOPPED, reason="FinalActionApp.step did not return", ticks=20)
    hung = change_tick(replace(whole, ticks=whole.ticks[:20], result=result), 19, asks=(), interventions=(cut,))
    replayed = replay(hung)
    assert (replayed.deviation, replayed.ticks, replayed.ended_by) == (None, 19, "FinalActionApp.step did not return")
