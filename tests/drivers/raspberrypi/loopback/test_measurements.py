from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from drivers.raspberrypi.loopback import motor_off_ground, ticks
from drivers.raspberrypi.loopback.echoes import measure_echoes
from drivers.raspberrypi.loopback.edges import StopTrial
from drivers.raspberrypi.loopback.encoder_edges import measure_encoders
from drivers.raspberrypi.loopback.motor_program import MotorProgramRequest
from drivers.raspberrypi.loopback.outputs import measure_levels, measure_pwm
from drivers.raspberrypi.loopback.percentiles import Percentiles
from drivers.raspberrypi.loopback.raspberry_pi import PiLoopbackTest
from drivers.raspberrypi.loopback.stops import WAYS, build_stop_result
from drivers.raspberrypi.loopback.ticks import Jitter, build_jitter_result
from robotcore.errors import DeviceError
from robotcore.hal.loopback import LoopbackRequest, RuleResult, Verdict
from tests.drivers.raspberrypi.loopback.conftest import WIRES

SWAPPED = (WIRES[1]._replace(output=WIRES[0].output), WIRES[0]._replace(output=WIRES[1].output))
"""Wires whose outputs are swapped."""


def map_by_rule(results: Any) -> dict[str, RuleResult]:
    return {result.rule: result for result in results}


def test_levels_follow_over_both_wires(wired_pins: Any) -> None:
    found = map_by_rule(measure_levels(WIRES, wired_pins))
    assert (found["levels"].verdict, found["levels"].values) == (Verdict.PASSED, {"wrong": 0, "levels": 100})
    assert 0 < found["output-latency"].values["worst_ms"] < 100


@pytest.mark.slow
def test_levels_that_do_not_follow_fail_both_rules(wired_pins: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.raspberrypi.loopback.outputs.LATE_S", 0.01)
    found = map_by_rule(measure_levels([WIRES[0]._replace(output=13)], wired_pins))
    assert (found["levels"].verdict, found["output-latency"].verdict) == (Verdict.FAILED, Verdict.FAILED)
    assert found["levels"].values["wrong"] == 50


@pytest.mark.slow
def test_the_duty_of_a_motor_is_seen_at_the_other_end(wired_pins: Any) -> None:
    """The double of lgpio is polled, so its frequency is not exact on a busy machine."""
    found = map_by_rule(measure_pwm(WIRES, wired_pins))
    for duty in (25, 50, 75):
        values = found[f"pwm-duty-{duty}"].values
        assert values["duty"] == pytest.approx(duty / 100, abs=0.1)
        assert values["edges_backward"] == 0


@pytest.mark.slow
def test_pwm_on_the_wrong_wire_fails(wired_pins: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.raspberrypi.loopback.outputs.PWM_S", 0.1)
    found = map_by_rule(measure_pwm(SWAPPED, wired_pins))
    assert found["pwm-duty-50"].verdict is Verdict.FAILED


@pytest.mark.slow
def test_the_drivers_of_encoders_count_every_edge_and_both_directions_of_quadrature(
    wired_pins: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drivers.raspberrypi.loopback.encoder_edges.RATES", (200,))
    found = map_by_rule(measure_encoders(WIRES, wired_pins))
    assert {rule: each.values["lost"] for rule, each in found.items()} == {"pulses-200": 0, "quadrature-200": 0}
    reversed_ = map_by_rule(measure_encoders(SWAPPED, wired_pins))
    assert reversed_["quadrature-200"].verdict is Verdict.FAILED  # counts backward


@pytest.mark.slow
def test_the_driver_of_the_ultrasonic_module_measures_the_echo_of_a_known_length(
    wired_pins: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drivers.raspberrypi.loopback.echoes.DISTANCES_M", (1.0,))
    monkeypatch.setattr("drivers.raspberrypi.loopback.echoes.RULES", ("echo-100cm",))
    (found,) = measure_echoes(WIRES, wired_pins)
    assert found.values["echoes"] == 10
    assert found.values["median_error_m"] < 0.2


@pytest.mark.slow
def test_without_an_echo_the_rule_fails_with_the_reason(wired_pins: Any) -> None:
    found = next(measure_echoes((WIRES[0], WIRES[1]._replace(output=13)), wired_pins))
    assert (found.verdict, found.measured) == (Verdict.FAILED, "no echo")
    assert "trigger" in found.reason


def test_jitter_is_the_difference_from_the_period_and_a_late_tick_counts() -> None:
    jitter = Jitter.from_times([0.0, 0.05, 0.13, 0.15], 20.0)
    assert jitter.late_ticks == 1
    assert jitter.percentiles == pytest.approx(Percentiles(0.03, 0.03, 0.03))


@pytest.mark.parametrize(
    "late_s, verdict", [(0.0, Verdict.PASSED), (0.024, Verdict.PASSED), (0.03, Verdict.FAILED), (0.08, Verdict.FAILED)]
)
def test_ticks_fail_if_more_than_one_in_a_hundred_is_late_by_half_a_period(late_s: float, verdict: Verdict) -> None:
    times = [number * 0.05 + (late_s if number % 20 == 19 else 0.0) for number in range(201)]
    assert build_jitter_result("ticks-20hz", Jitter.from_times(times, 20.0), 20.0).verdict is verdict


def test_ticks_fail_if_the_deadman_had_stopped_the_motors_once() -> None:
    times = [number * 0.05 + (0.076 if number >= 500 else 0.0) for number in range(1000)]
    assert build_jitter_result("ticks-20hz", Jitter.from_times(times, 20.0), 20.0).verdict is Verdict.FAILED


@pytest.mark.parametrize(
    "low_after_s, was_high, verdict",
    [
        (0.02, True, Verdict.PASSED),
        (0.2, True, Verdict.FAILED),
        (None, True, Verdict.FAILED),
        (None, False, Verdict.FAILED),
    ],
)
def test_a_stop_passes_only_if_the_motor_turned_before_and_its_pin_was_low_in_time(
    low_after_s: float | None, was_high: bool, verdict: Verdict
) -> None:
    trials = [StopTrial(was_high=True, low_after_s=0.01), StopTrial(was_high, low_after_s)]
    result = build_stop_result(WAYS[0], trials, others=0)
    assert result.verdict is verdict
    assert result.values["low_before"] == (not was_high)


def test_a_motor_that_turned_in_no_trial_has_no_time_of_a_stop() -> None:
    result = build_stop_result(WAYS[0], [StopTrial(was_high=False, low_after_s=None)], others=0)
    assert (result.verdict, result.values.get("worst_ms")) == (Verdict.FAILED, None)


def test_the_rules_that_a_failed_device_leaves_without_a_result_fail() -> None:
    def measure() -> Iterator[RuleResult]:
        yield RuleResult.from_measurement("a", "1", "1", is_met=True)
        raise DeviceError("motor", "it was unplugged", kind="unplugged")

    request = LoopbackRequest(wires=((20, 21), (19, 26)))
    found = list(PiLoopbackTest(request, ())._measure_step(("a", "b", "c"), measure))
    assert [each.verdict for each in found] == [Verdict.PASSED, Verdict.FAILED, Verdict.FAILED]


def test_a_rule_for_which_a_step_yields_no_result_fails() -> None:
    request = LoopbackRequest(wires=((20, 21), (19, 26)))
    (found,) = PiLoopbackTest(request, ())._measure_step(("a",), lambda: iter(()))
    assert (found.rule, found.verdict) == ("a", Verdict.FAILED)
    assert found.reason


def test_ticks_without_the_wanted_priority_fail_with_the_notes_about_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    events = {
        "ticks": {"times": [0.0, 0.05], "priority": 0, "locked_kb": 0},
        "result": {"real_time_notes": ["--rt: refused. Raise the limit", "--rt: not locked"]},
    }
    program = Mock(await_event=lambda name, *_: events[name])
    monkeypatch.setattr(ticks, "run_program", lambda _: nullcontext(program))
    monkeypatch.setattr(ticks, "load_processors", lambda: nullcontext(0))
    found = list(ticks.measure_ticks(WIRES, tmp_path, 1.0, str, is_real_time=True))
    assert [each.rule for each in found] == list(ticks.RT_RULES)
    assert {each.verdict for each in found} == {Verdict.FAILED}
    assert {each.reason for each in found} == {"--rt: refused. Raise the limit. --rt: not locked"}


@pytest.mark.parametrize(
    "is_running, result, verdict",
    [
        (True, None, Verdict.PASSED),
        (False, None, Verdict.FAILED),
        (False, {"exit_status": 3, "reason": "the board is gone"}, Verdict.FAILED),
        (False, {"exit_status": 0, "reason": ""}, Verdict.FAILED),
    ],
)
def test_a_wheel_that_stands_still_counts_only_if_its_run_has_not_ended(
    is_running: bool, result: dict[str, Any] | None, verdict: Verdict
) -> None:
    events = {"stop": {"at": 1.0}, "result": result}
    program = Mock(is_running=is_running, await_event=lambda name, *_: events[name], describe_failure=lambda: "killed")
    found = motor_off_ground._ask_during_run("motor-stop", "stop", program, Mock(choose=lambda *_: "y"))
    assert found.verdict is verdict


class AnsweringPerson:
    """A person who confirms everything, and answers each question as given."""

    def __init__(self, **answers: str) -> None:
        self._answers = answers

    def confirm(self, _topic: str, _instruction: str) -> bool:
        return True

    def choose(self, topic: str, _question: str, _choices: Any) -> str:
        return self._answers[topic]


def test_after_a_failed_stop_the_motor_is_not_turned_again(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    @contextmanager
    def run(request: MotorProgramRequest) -> Iterator[Any]:
        started.append(request.action)
        yield Mock(await_event=lambda *_: {"exit_status": 0}, is_running=True)

    monkeypatch.setattr(motor_off_ground, "run_program", run)
    motor = Mock(max_velocity_rad_s=10.0)
    motor.name = "left_motor"
    person = AnsweringPerson(direction="f", stop="n", deadman="s")
    found = [each.verdict.value for each in motor_off_ground.check_motor(motor, "rover", person, str)]
    assert (started, found) == (["drive", "stop"], ["passed", "failed", "skipped"])


def test_after_a_failed_stop_over_the_wires_no_motor_is_turned(monkeypatch: pytest.MonkeyPatch) -> None:
    results = iter([RuleResult.fail("stop-sigkill", "the pin stayed high")])
    test = PiLoopbackTest.__new__(PiLoopbackTest)
    test.wires, test._motor, test._request = WIRES, Mock(), LoopbackRequest()
    monkeypatch.setattr(PiLoopbackTest, "_measure_over_wires", lambda *_: results)
    monkeypatch.setattr("drivers.raspberrypi.loopback.raspberry_pi.release_low", lambda _: None)
    found = [(each.rule, each.verdict.value) for each in test.run(AnsweringPerson(), str)]
    assert found[1:] == [(rule, "skipped") for rule in motor_off_ground.RULES]
