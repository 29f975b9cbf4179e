"""Compare the costs of robotcore's drivers for motors and encoders with those of gpiozero's devices, on mock pins.

    python -m benchmarks.pins

Each driver is timed right after gpiozero's device, in turn, so that load on the machine affects both. A command sets
two velocities in turn; `Motor.value` gets the same duty cycles. An encoder is read once an instant, as by an app.
`RotaryEncoder.steps` is an attribute, without time and unit. An edge is the cost of the callback of a turning wheel,
which has four edges a cycle. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from time import perf_counter

from gpiozero import Motor, RotaryEncoder
from gpiozero.pins.mock import MockFactory, MockPWMPin

from benchmarks.pairs import paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from robotcore.description import load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device, Encoder
from robotcore.hal.devices import Motor as OurMotor
from robotcore.hardware import Host, bind_devices, open_devices

BOUND = 1.1
FASTER, SLOWER = 8.0, 4.0
Work = Callable[[int], None]


def main() -> int:
    """Measure every pair of calls, and print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=at_least_one, default=41)
    parser.add_argument("--calls", type=at_least_one, default=4000)
    options = parser.parse_args()
    motor, encoder, clock, pins = _open_devices()
    theirs = MockFactory(pin_class=MockPWMPin)
    wheel, knob = Motor(17, 27, pin_factory=theirs), RotaryEncoder(5, 6, max_steps=0, pin_factory=theirs)
    cases: list[tuple[str, Work, Work]] = [
        ("h-bridge set_velocity against Motor.value", _make_commands(motor), _make_values(wheel)),
        ("h-bridge set_velocity against Motor.forward", _make_commands(motor), _make_forwards(wheel)),
        ("h-bridge stop against Motor.stop", _make_calls(motor.stop), _make_calls(wheel.stop)),
        ("quadrature edge against RotaryEncoder's", _make_edges(pins), _make_edges(theirs)),
        ("quadrature read against RotaryEncoder.steps", _make_reads(encoder, clock), _make_steps(knob)),
    ]
    rows, are_bound = [], []
    for name, our, other in cases:
        spent: tuple[list[float], list[float]] = ([], [])
        median, low, high = paired_ratios(
            _make_timer(our, options.calls, spent[0]), _make_timer(other, options.calls, spent[1]), options.pairs
        )
        rows.append((name, f"{min(spent[0]):.2f}", f"{min(spent[1]):.2f}", f"{median:.2f}", f"{low:.2f} to {high:.2f}"))
        are_bound.append(median <= BOUND)
    print(machine())
    print_table(("µs a call, least; ratio, median", "ours", "gpiozero's", "ratio", "95 % interval of it"), rows)
    print(f"bound: {BOUND:g} for all but a read")
    return int(not all(are_bound[:-1]))


def _open_devices() -> tuple[OurMotor, Encoder, SteppedClock, MockFactory]:
    robot, pins, opened = load_robot("rover"), MockFactory(pin_class=MockPWMPin), dict[str, Device]()
    section = {name: robot.backends["raspberrypi"][name] for name in ("left_motor", "left_encoder")}
    robot = robot.model_copy(update={"backends": {"raspberrypi": section}})
    clock = SteppedClock(20.0, lambda _make_steps: None)
    open_devices(bind_devices(robot, "raspberrypi", section), Host(robot, clock, pins, opened), opened)
    motor, encoder = opened["left_motor"], opened["left_encoder"]
    assert isinstance(motor, OurMotor)
    assert isinstance(encoder, Encoder)
    return motor, encoder, clock, pins


def _make_timer(work: Work, calls: int, spent: list[float]) -> Callable[[], float]:
    def once() -> float:
        start = perf_counter()
        work(calls)
        spent.append((perf_counter() - start) / calls * 1e6)
        return spent[-1]

    return once


def _make_commands(motor: OurMotor) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls // 2):
            motor.set_velocity(FASTER)
            motor.set_velocity(SLOWER)

    return work


def _make_values(motor: Motor) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls // 2):
            motor.value = 0.61
            motor.value = 0.36

    return work


def _make_forwards(motor: Motor) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls // 2):
            motor.forward(0.61)
            motor.forward(0.36)

    return work


def _make_calls(call: Callable[[], object]) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls):
            call()

    return work


def _make_edges(pins: MockFactory) -> Work:
    a, b = pins.pin(5), pins.pin(6)

    def work(calls: int) -> None:
        for _ in range(calls // 4):
            a.drive_low()
            b.drive_low()
            a.drive_high()
            b.drive_high()

    return work


def _make_reads(encoder: Encoder, clock: SteppedClock) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls):
            encoder.read()
            clock._count += 1  # noqa: SLF001  the next instant, without the price of sleeping

    return work


def _make_steps(encoder: RotaryEncoder) -> Work:
    def work(calls: int) -> None:
        for _ in range(calls):
            encoder.steps  # noqa: B018  what is timed

    return work


if __name__ == "__main__":
    sys.exit(main())
