"""Measure how an ultrasonic sensor's reader treats noisy and lost echoes, and what a read costs.

    python -m benchmarks.echoes

The module is simulated on mock pins and a stepped clock. Distances are from 5 cm to 2 m. Each echo has a normal error,
and a share of the echoes is lost, in which case the module's own time-out comes. All is drawn from a seed. The cost of
a read is compared with that of gpiozero's DistanceSensor, in pairs.

The exit status is 1 if a value is off by more than 1 cm beside the drawn error, if a lost echo gives a value, or if an
echo gives none.
"""

from __future__ import annotations

import argparse
import random
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import perf_counter

from benchmarks.pairs import paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from tests.drivers.raspberrypi.ranging.modules import ECHO, NO_ECHO, NOSE, TRIGGER, Bench, Edges, build_echo

BOUND_M = 0.01
NOISE_M = 0.003
"""The standard deviation of a measured distance, in metres. Source: data sheet of the HC-SR04, ElecFreaks."""
LOST = 0.1
READS = 2000
OFF = "received, but measured with an error of more than 1 cm beside the drawn one"
WRONG = (OFF, "received, no sample", "lost, measured as a distance", "lost, measured as inf")


@dataclass(frozen=True)
class Echo:
    """A true distance in metres, and the distance of the echo, or None if it is lost."""

    true: float
    heard: float | None

    @property
    def edges(self) -> Edges:
        return NO_ECHO if self.heard is None else build_echo(self.heard)


def main() -> int:
    """Print the results of the echoes, and the cost of a read."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=at_least_one, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--pairs", type=at_least_one, default=40)
    options = parser.parse_args()
    print(machine())
    counts, worst = _judge_echoes(options.cycles, random.Random(options.seed))
    print_table((f"of {options.cycles} cycles", ""), [(what, str(count)) for what, count in counts.items()])
    print(f"furthest from the truth: {worst * 1000:.1f} mm; standard deviation of the echoes: {NOISE_M * 1000:g} mm")
    ratio, low, high = _compare_cost(options.pairs)
    print(f"a read against gpiozero's DistanceSensor.distance: {ratio:.3f} ({low:.3f} to {high:.3f})")
    return int(any(counts[what] for what in WRONG))


def _judge_echoes(cycles: int, draw: random.Random) -> tuple[Counter[str], float]:
    """Simulate echoes. Return the number of cycles with each result, and the largest error of a distance in metres."""
    echoes = [Echo(1.0, 1.0), *_draw_echoes(cycles, draw)]
    bench = Bench([echo.edges for echo in echoes])
    counts, worst = Counter(dict.fromkeys(("received, measured", "lost, no sample", *WRONG), 0)), 0.0
    sensor = bench.open()
    sequence = sensor.read().sequence
    for echo in echoes[1:]:
        bench.cycles()
        sample = sensor.read()
        counts[_judge_echo(echo, sample.distance, is_new=sample.sequence > sequence)] += 1
        if echo.heard is not None:
            worst = max(worst, abs(sample.distance - echo.true))
        sequence = sample.sequence
    sensor.close()
    return counts, worst


def _draw_echoes(count: int, draw: random.Random) -> Iterator[Echo]:
    for _ in range(count):
        true = draw.uniform(0.05, 1.98)
        error = draw.gauss(0.0, NOISE_M)
        yield Echo(true, None if draw.random() < LOST else true + error)


def _judge_echo(echo: Echo, distance: float, *, is_new: bool) -> str:
    if echo.heard is None:
        if not is_new:
            return "lost, no sample"
        return "lost, measured as inf" if distance == float("inf") else "lost, measured as a distance"
    if not is_new:
        return "received, no sample"
    return "received, measured" if abs(distance - echo.heard) <= BOUND_M else OFF


def _compare_cost(pairs: int) -> tuple[float, float, float]:
    """Return the ratio between the times of a read and of gpiozero's read, with its 95 % interval."""
    from gpiozero import DistanceSensor
    from gpiozero.pins.mock import MockFactory, MockPin, MockTriggerPin

    pins = MockFactory(pin_class=MockPin)
    pins.pin(TRIGGER, pin_class=MockTriggerPin, echo_pin=pins.pin(ECHO), echo_time=0.002)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = DistanceSensor(ECHO, TRIGGER, max_distance=NOSE.max_range_m, pin_factory=pins)
    ours = Bench([build_echo(1.0)]).open()
    with theirs:
        return paired_ratios(lambda: _time_reads(ours.read), lambda: _time_reads(lambda: theirs.distance), pairs)


def _time_reads(read: Callable[[], object]) -> float:
    start = perf_counter()
    for _ in range(READS):
        read()
    return perf_counter() - start


if __name__ == "__main__":
    sys.exit(main())
