"""Measures how soon each way to stop pulls the motor's pin low: a command, the deadman, signals, the guardian."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from drivers.raspberrypi.cutoff import RELEASE_S
from drivers.raspberrypi.loopback.board import MAX_RAD_S, MOTOR, write_loopback_robot
from drivers.raspberrypi.loopback.edges import EdgeRecorder, StopTrial
from drivers.raspberrypi.loopback.motor_program import Action, MotorProgramRequest
from drivers.raspberrypi.loopback.processes import LoopbackProgram, run_program
from drivers.raspberrypi.loopback.ticks import compute_lease
from drivers.raspberrypi.loopback.wires import LoopbackWire
from drivers.raspberrypi.motors.boards import MAX_SILENCE_S
from drivers.raspberrypi.pins import open_pins
from robotcore.hal.loopback import RuleResult
from robotcore.safety.deadman import LOCK_TIMEOUT_S

RATE_HZ = 20.0
LEASE_S = compute_lease(RATE_HZ)
SILENCE_S = LEASE_S + LOCK_TIMEOUT_S + MAX_SILENCE_S + RELEASE_S
"""The guardian waits for its lease and for the longest silence of an app without a standby line. Then it kills the app,
and the kernel releases the lines."""


class StopWay(NamedTuple):
    """A way to stop the motor."""

    rule: str
    action: Action
    bound_s: float
    """The promised time from the event until the pin is low, see the page "Safety"."""
    signal_number: int = 0
    """The signal that this test sends; 0 for none."""


WAYS = (
    StopWay("stop-command", "stop", 1 / RATE_HZ),
    StopWay("stop-deadman", "hang", LEASE_S + LOCK_TIMEOUT_S),
    StopWay("stop-sigterm", "drive", 0.1, signal.SIGTERM),
    StopWay("stop-sigkill", "drive", RELEASE_S, signal.SIGKILL),
    StopWay("stop-guardian", "block", SILENCE_S),
)
RULES = tuple(way.rule for way in WAYS)
TRIALS = 3
AFTER_S = 0.5
"""The test watches the pin for this time after the bound, in seconds, to check that it stays low."""

WINDOW_S = 0.5
"""The pin is watched for this time after a stop, after which the same program turns the motor again."""


def measure_stops(wires: Sequence[LoopbackWire], folder: Path, write: Callable[[str], object]) -> Iterator[RuleResult]:
    """Turn the motor at full duty in another program, stop it in each way, and yield the times at the pins."""
    robot = write_loopback_robot(wires, folder)
    for way in WAYS:
        write(f"{way.rule}: {TRIALS} times, within {way.bound_s * 1e3:.0f} ms")
        with closing(open_pins()) as pins:
            yield _measure(way, str(robot), wires, pins)


def _measure(way: StopWay, robot: str, wires: Sequence[LoopbackWire], pins: Any) -> RuleResult:
    is_repeated = way.action in ("stop", "hang")  # in one program
    request = MotorProgramRequest(
        robot, MOTOR, MAX_RAD_S, way.action, trials=TRIALS if is_repeated else 1, rate_hz=RATE_HZ, rest_after_s=0.5
    )
    trials: list[StopTrial] = []
    with EdgeRecorder(wires[0].input, pins) as forward, EdgeRecorder(wires[1].input, pins) as backward:
        for _ in range(1 if is_repeated else TRIALS):
            with run_program(request) as program:
                if program.await_event("driving") is None:
                    return RuleResult.fail(way.rule, f"the run failed: {program.describe_failure()}")
                if not _is_turning(forward, pins):
                    return RuleResult.fail(way.rule, "the pin did not become high. Check wire 1")
                for _ in range(request.trials):
                    trial = _stop_once(way, program, forward, pins)
                    if trial is None:
                        return RuleResult.fail(way.rule, f"the run failed: {program.describe_failure()}")
                    trials.append(trial)
        others = len(backward.edges)
    return build_stop_result(way, trials, others)


def _is_turning(forward: EdgeRecorder, pins: Any) -> bool:
    return forward.is_high or forward.wait_for(is_high=True, since=pins.ticks(), timeout_s=2.0) is not None


def _stop_once(way: StopWay, program: LoopbackProgram, forward: EdgeRecorder, pins: Any) -> StopTrial | None:
    """Stop the motor, and return how soon its pin was low; None if the program ended before."""
    if way.signal_number:
        at = float(pins.ticks())
        program.send_signal(way.signal_number)
    else:
        event = program.await_event(way.action)
        if event is None:
            return None
        at = float(event["at"])
    return forward.find_stop(
        at, at + (way.bound_s + AFTER_S if way.signal_number or way.action == "block" else WINDOW_S)
    )


def build_stop_result(way: StopWay, trials: Sequence[StopTrial], others: int) -> RuleResult:
    """Return whether the pin became low in time in each trial.

    others: the number of edges at the pin of the other direction, which must stay low.
    """
    count = len(trials)
    low = [trial.low_after_s for trial in trials if trial.low_after_s is not None]
    turning = sum(trial.was_high for trial in trials)
    worst = f"worst {max(low) * 1e3:.1f} ms" if low else "no stop was measured"
    still = f", {turning - len(low)} of {count} times still high" if len(low) < turning else ""
    standing = f", {count - turning} of {count} times low before the stop" if turning < count else ""
    return RuleResult.from_measurement(
        way.rule,
        f"{worst} of {count}{still}{standing}" if low else f"{worst}{still}{standing}",
        f"at most {way.bound_s * 1e3:.0f} ms",
        is_met=len(low) == count and max(low) <= way.bound_s and not others,
        reason="Do not drive with this Pi. Send the report",
        trials=count,
        still_high=turning - len(low),
        low_before=count - turning,
        edges_backward=others,
        **({"worst_ms": round(max(low) * 1e3, 3)} if low else {}),
    )
