"""Measures echo pulses of a known length with the driver of the HC-SR04."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, suppress
from threading import Event
from typing import Any

from drivers.raspberrypi.loopback.board import build_context
from drivers.raspberrypi.loopback.edges import EdgeRecorder
from drivers.raspberrypi.loopback.wires import LoopbackWire
from drivers.raspberrypi.pins import open_output
from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic, speed_of_sound
from robotcore.description import Mount
from robotcore.errors import DeviceError
from robotcore.hal.loopback import RuleResult
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.threads import start_thread

DISTANCES_M = (0.1, 1.0, 3.0)
ECHOES = 10
"""The number of echoes for each distance."""

DELAY_S = 0.0005
"""The time from the trigger to the echo pulse. Source: HC-SR04 data sheet, ElecFreaks: eight cycles of 40 kHz."""

ERROR_BOUND_M = 0.01
"""The greatest median error: the echo of a wall differs by as much, because the sound is warmer or colder by 3 °C."""

SONAR = RangeSensorDescription(
    kind="range_sensor", name="sonar", mount=Mount(z_m=0.0), min_range_m=0.02, max_range_m=4.0, cone_rad=0.3
)
SPIN_S = 0.002
WAIT_S = 0.005
LIMIT_S = 3.0
_SPEED = speed_of_sound(Ultrasonic.model_fields["air_temperature_c"].default)
RULES = tuple(f"echo-{distance * 100:.0f}cm" for distance in DISTANCES_M)


class EchoModule:
    """An ultrasonic module in a thread: it answers each trigger by a pulse of a known length.

    trigger: the input at which the trigger arrives.
    output: the output that sends the pulse.
    length_s: the length of the pulse in seconds.
    pins: gpiozero's pin factory.
    """

    def __init__(self, trigger: EdgeRecorder, output: Any, length_s: float, pins: Any) -> None:
        self._trigger, self._output, self._length_s, self._now = trigger, output, length_s, pins.ticks
        self._is_over = Event()
        self.sent: list[float] = []
        """The true length of each pulse, in seconds."""
        self._thread = start_thread(self._work, "echo module")

    def close(self) -> None:
        """End the thread."""
        self._is_over.set()
        self._thread.join()

    def _work(self) -> None:
        answered = 0
        while not self._is_over.wait(0.0005):
            falls = sum(not edge.is_high for edge in tuple(self._trigger.edges))
            if falls > answered:
                answered = falls
                self._answer()

    def _answer(self) -> None:
        self._wait_until(self._now() + DELAY_S)
        before = self._now()
        self._output.on()
        rose = (before + self._now()) / 2
        self._wait_until(rose + self._length_s)
        before = self._now()
        self._output.off()
        self.sent.append((before + self._now()) / 2 - rose)

    def _wait_until(self, due: float) -> None:
        if (left := due - self._now()) > SPIN_S:
            Event().wait(left - SPIN_S)
        while self._now() < due:
            pass


def measure_echoes(wires: Sequence[LoopbackWire], pins: Any) -> Iterator[RuleResult]:
    """Answer the driver's triggers, over wire 1, by echoes over wire 2. Yield the errors of the distances."""
    for rule, distance in zip(RULES, DISTANCES_M, strict=True):
        yield _measure(rule, distance, wires, pins)


def _measure(rule: str, distance: float, wires: Sequence[LoopbackWire], pins: Any) -> RuleResult:
    first, second = wires
    driver = Ultrasonic(trigger=first.output, echo=second.input)
    bound = f"median error at most {ERROR_BOUND_M * 100:g} cm"
    with ExitStack() as opened:
        trigger = opened.enter_context(EdgeRecorder(first.input, pins))
        output = open_output("loopback", second.output, pins, opened)
        module = opened.enter_context(closing(EchoModule(trigger, output, 2 * distance / _SPEED, pins)))
        try:
            sensor = opened.enter_context(closing(driver.open(SONAR, build_context(wires, pins))))
        except DeviceError as error:
            return RuleResult.from_measurement(
                rule, "no echo", bound, is_met=False, reason=str(error).partition(": ")[2]
            )
        pairs = _collect(sensor, module, pins.ticks)
    if not pairs:
        return RuleResult.from_measurement(rule, "no echo", bound, is_met=False, reason="Check both wires")
    errors = [abs(measured - true) for measured, true in pairs]
    median, worst = statistics.median(errors), max(errors)
    return RuleResult.from_measurement(
        rule,
        f"median error {median * 100:.2f} cm, worst {worst * 100:.2f} cm, of {len(pairs)} echoes",
        bound,
        is_met=median <= ERROR_BOUND_M and len(pairs) == ECHOES,
        reason="End other programs on the Pi",
        median_error_m=round(median, 5),
        worst_error_m=round(worst, 5),
        echoes=len(pairs),
    )


def _collect(sensor: Any, module: EchoModule, now: Any) -> list[tuple[float, float]]:
    """Return the measured and the true distance of each echo, in metres."""
    pairs: list[tuple[float, float]] = []
    last, end = -1, now() + LIMIT_S
    while len(pairs) < ECHOES and now() < end:
        with suppress(DeviceError):  # the next echo counts
            sample = sensor.read()
            if sample.sequence > last and module.sent:
                last = sample.sequence
                pairs.append((sample.distance, module.sent[-1] * _SPEED / 2))
        Event().wait(WAIT_S)
    return pairs
