"""Tests one motor of the user's robot off the ground: its direction, a stop, and the deadman."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from drivers.raspberrypi.loopback.motor_program import Action, MotorProgramRequest
from drivers.raspberrypi.loopback.processes import START_S, LoopbackProgram, run_program
from robotcore.errors import UnknownNameError, UsageError
from robotcore.hal.loopback import LoopbackPerson, LoopbackRequest, RuleResult, Verdict
from robotcore.kinds.motor import MotorDescription

RULES = ("motor-direction", "motor-stop", "motor-deadman")
LIFT_INSTRUCTION = (
    "Lift the robot so that its wheels turn freely, switch the motors' supply on, and stay beside its switch. The "
    "wheel of {motor} turns three times for a short time, at half speed"
)
QUESTIONS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "direction": ("which way did the wheel turn", {"f": "forward", "b": "backward", "n": "not at all"}),
    "stop": ("does the wheel stand still now", {"y": "yes", "n": "no"}),
    "deadman": (
        "the program hung for 3 s while the wheel turned. When did the wheel stop",
        {"s": "at once", "l": "only after the 3 s", "n": "it still turns"},
    ),
}
EXPECTED_ANSWERS = {"direction": "f", "stop": "y", "deadman": "s"}
"""The answer to each question if the motor works."""

HANG_S = 2.9
"""The step of the app does not return for this time, in seconds: less than the watchdog's limit."""

ANSWER_S = 120.0
"""The run with the stop ends after this time in seconds, so the person must answer before that."""

VELOCITY_SHARE = 0.5
REMEDY = {
    "direction": "Correct the wires, or the file: robotcore test-devices --write",
    "stop": "Switch the motors' supply off. Do not drive with this robot. Send the report",
    "deadman": "Switch the motors' supply off. Do not drive with this robot. Send the report",
}


FAILED_STOP_REASON = "a rule about a stop failed, so the test turns no motor again"
"""The reason for a skipped rule after a failed stop."""


def find_motor(request: LoopbackRequest) -> MotorDescription | None:
    """Return the motor to test; None without a robot. Raises UsageError if the robot has no such motor."""
    if request.robot is None:
        if request.motor:
            text = "--motor has no effect without --robot. Name the robot's file: --robot my_robot.toml"
            raise UsageError(text, kind="option-without-effect", option="--motor")
        return None
    motors = {motor.name: motor for motor in request.robot.all_of(MotorDescription)}
    if not motors:
        text = f"{request.robot.name!r} has no motor to test. Leave --robot out, or name another robot"
        raise UsageError(text, kind="no-motor")
    if request.motor and request.motor not in motors:
        raise UnknownNameError("motor", request.motor, list(motors))
    return motors[request.motor] if request.motor else next(iter(motors.values()))


def check_motor(
    motor: MotorDescription | None, robot: str, person: LoopbackPerson, write: Callable[[str], object]
) -> Iterator[RuleResult]:
    """Turn the motor in three runs of another program, and yield a result for each answer of the person.

    After a stop that failed, the motor is not turned again.
    """
    if motor is None:
        yield from (RuleResult.skip(rule, "no robot was named. Add --robot FILE") for rule in RULES)
        return
    if not person.confirm("lift", LIFT_INSTRUCTION.format(motor=motor.name)):
        yield from (
            RuleResult.skip(rule, "the user did not confirm that the wheels are off the ground") for rule in RULES
        )
        return
    action: Action
    has_failed_stop = False
    for rule, topic, action in (
        ("motor-direction", "direction", "drive"),
        ("motor-stop", "stop", "stop"),
        ("motor-deadman", "deadman", "hang"),
    ):
        if has_failed_stop:
            yield RuleResult.skip(rule, FAILED_STOP_REASON)
            continue
        write(f"{rule}: the wheel turns")
        duration_s = {"drive": 1.5, "hang": 5.0, "stop": ANSWER_S}[action]
        request = MotorProgramRequest(
            robot,
            motor.name,
            motor.max_velocity_rad_s * VELOCITY_SHARE,
            action,
            duration_s=duration_s,
            hang_s=HANG_S,
            rest_after_s=ANSWER_S if action == "stop" else 0.0,
        )
        with run_program(request) as program:
            if action == "stop":
                result = _ask_during_run(rule, topic, program, person)
                has_failed_stop = result.verdict is Verdict.FAILED
                yield result
            else:
                yield _ask_after_run(rule, topic, program, START_S + duration_s, person)


def _ask_during_run(rule: str, topic: str, program: LoopbackProgram, person: LoopbackPerson) -> RuleResult:
    """Ask while the run goes on, because its end would stop the wheel too."""
    if program.await_event("stop") is None:
        return RuleResult.fail(rule, f"the run failed: {program.describe_failure()}")
    answer = _ask(rule, topic, person)
    if program.is_running or answer.verdict is not Verdict.PASSED:
        return answer
    result = program.await_event("result")  # the end of the run may have stopped the wheel
    if result is None or result["exit_status"]:
        return _fail_run(rule, result, program)
    return RuleResult.fail(rule, f"the run had ended before the answer. Answer within {ANSWER_S:g} s")


def _ask_after_run(
    rule: str, topic: str, program: LoopbackProgram, timeout_s: float, person: LoopbackPerson
) -> RuleResult:
    result = program.await_event("result", timeout_s)
    if result is None or result["exit_status"]:
        return _fail_run(rule, result, program)
    return _ask(rule, topic, person)


def _fail_run(rule: str, result: Mapping[str, Any] | None, program: LoopbackProgram) -> RuleResult:
    reason = result["reason"] if result else program.describe_failure()
    return RuleResult.fail(rule, f"the run failed: {reason}")


def _ask(rule: str, topic: str, person: LoopbackPerson) -> RuleResult:
    question, choices = QUESTIONS[topic]
    answer = person.choose(topic, question, choices)
    if answer is None:
        return RuleResult.skip(rule, "the question was skipped")
    wanted = choices[EXPECTED_ANSWERS[topic]]
    verdict = Verdict.PASSED if answer == EXPECTED_ANSWERS[topic] else Verdict.FAILED
    return RuleResult(rule, verdict, choices[answer], wanted, "" if verdict is Verdict.PASSED else REMEDY[topic])
