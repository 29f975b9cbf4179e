"""Verification of recordings."""

from __future__ import annotations

import re
import signal
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, get_args

import pytest

from robotcore.errors import EmergencyStopError, Interrupted, RecordingError
from robotcore.geometry import Wheels
from robotcore.recording import RecordedError, Recording, Tick
from robotcore.recording.replay import is_recorded_app, replay
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety.velocity_limits import Intervention
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import (
    Disturbance,
    change_tick,
    press_emergency_stop,
    record_run,
    send_signal,
)
from tests.robotcore.recording.replay.recorded_apps import FinalAction, FinalActionApp
from tests.texts import Raises

APPS = str(Path(__file__).parent / "recorded_apps.py")


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


def test_compensated_samples_are_replayed_bit_equal(tmp_path: Path) -> None:
    file = tmp_path / "worn.toml"
    file.write_text(ROVER.replace('name = "nose"', 'name = "nose"\noffset_m = 0.05\nloss = 0.2'))
    require_equal(record_run("avoid-obstacles", robot=str(file), seed=3, timeout_s=6.0))


def get_result(recording: Recording) -> RunResult:
    assert recording.result
    return recording.result


@pytest.mark.parametrize("action", get_args(FinalAction))
def test_run_with_any_end_is_replayed_bit_equal(action: str) -> None:
    require_equal(record_final_action(action))


@pytest.mark.parametrize(
    "faults", [(), ("range noise=0.2", "range drop=0.3", "encoders slip=0.3"), ("range lost=0.5 after=1",)]
)
def test_routine_is_replayed_bit_equal(faults: tuple[str, ...]) -> None:
    require_equal(record_run(f"{APPS}:RoutineApp", seed=3, timeout_s=6.0, faults=faults))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "pybullet"])
@pytest.mark.parametrize(
    "faults",
    [
        ("camera drop=0.3", "range noise=0.1"),
        ("encoders freeze after=0.5",),
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


def test_pose_without_encoders_is_computed_from_the_recorded_angles(tmp_path: Path) -> None:
    robot = tmp_path / "blind.toml"
    rover = resources.files("robotcore.description").joinpath("robots/rover.toml").read_text()
    parts = [part for part in rover.split("\n\n") if 'kind = "encoder"' not in part]
    robot.write_text("\n".join(line for line in "\n\n".join(parts).split("\n") if "_encoder =" not in line))
    recording = record_final_action("stop_and_go", robot=str(robot))
    assert "left_encoder" not in recording.metadata.devices
    robot.unlink()
    require_equal(recording)


def test_object_addresses_in_a_reason_are_ignored() -> None:
    recording = record_run(f"{APPS}:DisplayApp", robot="lookout", world="open", seed=3)
    assert "0x" in get_result(recording).reason
    require_equal(recording)


@pytest.mark.parametrize("pattern, text", [(r"recorded_apps\.py:\d+", "before.py:7"), (".+", "in other words")])
def test_line_numbers_and_messages_of_our_errors_are_ignored(pattern: str, text: str) -> None:
    recording = record_final_action("command_nan")
    last = recording.ticks[-1].error
    assert last
    assert ", at recorded_apps.py:" in last.message
    other = replace(last, message=re.sub(pattern, text, last.message))
    require_equal(change_tick(recording, len(recording.ticks) - 1, error=other))


def test_other_class_or_attribute_of_an_error_is_another_end() -> None:
    recording = record_run("avoid-obstacles", seed=3, timeout_s=6.0, faults=("range freeze after=1",))
    last = recording.ticks[-1].error
    assert last
    assert last.attributes["device"] == "nose"
    for error in (replace(last, kind="DeviceError"), replace(last, attributes={**last.attributes, "device": "eye"})):
        assert replay(change_tick(recording, len(recording.ticks) - 1, error=error)).deviation


HUNG = Intervention(1.0, "watchdog", Wheels(1.0, 1.0), Wheels(0.0, 0.0))


@pytest.mark.parametrize(
    "outcome, last, reason, ticks",
    [
        (Outcome.INTERRUPTED, {}, "interrupted by SIGINT", 20),
        (
            Outcome.INTERRUPTED,
            {"asks": (), "error": RecordedError.from_error(Interrupted(15))},
            "interrupted by SIGTERM",
            19,
        ),
        (Outcome.STOPPED, {"asks": (), "interventions": (HUNG,)}, "step did not return", 19),
        (Outcome.ERROR, {}, "the simulator has died", 20),
        (None, {}, "the file was cut before the run ended", 20),
    ],
)
def test_external_cause_ends_the_replay_in_the_same_tick_or_before_a_cut_one(
    outcome: Outcome | None, last: dict[str, Any], reason: str, ticks: int
) -> None:
    whole = record_final_action("go_on")
    result = replace(get_result(whole), outcome=outcome, reason=reason, trace_sha256=None) if outcome else None
    replayed = replay(change_tick(replace(whole, ticks=whole.ticks[:20], result=result), 19, **last))
    assert (replayed.deviation, replayed.ticks, replayed.ended_by, replayed.exit_status) == (None, ticks, reason, 0)


def test_recording_that_cannot_be_replayed_is_refused(raises: Raises) -> None:
    with raises(RecordingError, "recording-without-tick"):
        replay(replace(record_final_action(), ticks=[]))
    with raises(RecordingError, "recording-not-replayable", file="run.mcap"):
        replay(replace(record_final_action(), missing_inputs="the pictures of eye are JPEGs"), "run.mcap")


@pytest.mark.parametrize("app", [FinalActionApp, FinalActionApp(ticks=3, speed=0.35)])
def test_class_and_instance_are_verified_by_the_file_of_their_class(
    app: type[Behaviour] | Behaviour, raises: Raises
) -> None:
    recording = record_run(app, seed=3)
    file = f"{APPS}:FinalActionApp"
    assert is_recorded_app(recording, file)
    assert not is_recorded_app(recording, f"{APPS}:SwallowingApp")
    assert replay(recording, app=file).exit_status == 0
    with raises(RecordingError, "app-not-here", app="FinalActionApp"):
        replay(recording)


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


@pytest.mark.parametrize("difference, is_other_machine", [(1e-6, True), (1e-15, False)])
def test_larger_difference_is_a_deviation(difference: float, is_other_machine: bool) -> None:
    recording = change_command(record_final_action(), 3, difference)
    deviation = replay(change_platform(recording) if is_other_machine else recording).deviation
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


@pytest.mark.parametrize("is_in_tick", [False, True])
@pytest.mark.parametrize("app", ["avoid-obstacles", f"{APPS}:DisplayApp"])
@pytest.mark.parametrize("number", [None, signal.SIGINT, signal.SIGTERM])
def test_external_stop_ends_the_replay_in_the_same_tick(
    app: str, number: signal.Signals | None, *, is_in_tick: bool
) -> None:
    disturbance = Disturbance(6, send_signal(number) if number else press_emergency_stop, is_in_tick=is_in_tick)
    recording = record_run(app, disturbance=disturbance, seed=2, timeout_s=2.0)
    assert get_result(recording).outcome is (Outcome.INTERRUPTED if number else Outcome.STOPPED)
    replayed = replay(recording)
    cut_short = number and is_in_tick and len(recording.ticks) == 7
    assert (replayed.deviation, replayed.ticks) == (None, len(recording.ticks) - bool(cut_short))
    assert replayed.exit_status == 0
    if not number:
        assert (replayed.result.outcome, replayed.result.reason) == (Outcome.STOPPED, get_result(recording).reason)
        assert replayed.trace_sha256 == get_result(recording).trace_sha256


def test_stop_after_the_commands_of_a_tick_does_not_change_them() -> None:
    whole = record_final_action("go_on")
    pressed = RecordedError.from_error(EmergencyStopError("the button was pressed"))
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
