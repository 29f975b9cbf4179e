"""The loopback test of a Raspberry Pi: its rules in order, and the release of its pins."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack, closing, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from drivers.raspberrypi.chip import Chip
from drivers.raspberrypi.doctor.system import find_version, read_model
from drivers.raspberrypi.header import GPIOS
from drivers.raspberrypi.loopback import echoes, encoder_edges, motor_off_ground, outputs, stops, ticks
from drivers.raspberrypi.loopback.wires import RESERVED, LoopbackWire, choose_wires, find_problem, find_used_gpios
from drivers.raspberrypi.pins import open_pins
from robotcore.errors import BackendError, DeviceError
from robotcore.hal.loopback import LoopbackPerson, LoopbackRequest, LoopbackTest, RuleResult, Verdict
from robotcore.hardware import DeviceBinding
from robotcore.safety.real_time import require_real_time

WIRE_RULES = ("wire-1", "wire-2")
LIBRARIES = ("gpiozero", "lgpio", "numpy")
WIRES_INSTRUCTION = (
    "Switch the motors' supply off. Connect two jumper wires, best with 1 kΩ in each: {wires}. Nothing else may be "
    "connected to these pins"
)
NO_RT = "the test ran without --rt. Add --rt"

Measure = Callable[[], Iterator[RuleResult]]


class PiLoopbackTest(LoopbackTest):
    """Tests this Pi over two wires, and one motor of a robot.

    Raises UsageError for pins and motors that cannot be tested.

    bindings: the devices of the robot with their drivers, whose pins the wires must not use.
    """

    def __init__(self, request: LoopbackRequest, bindings: tuple[DeviceBinding, ...], root: Path = Path("/")) -> None:
        self._request, self._root = request, root
        self._used = find_used_gpios(bindings)
        self.wires = choose_wires(request.wires, self._used)
        self._motor = motor_off_ground.find_motor(request)
        if request.is_real_time:
            require_real_time()

    @property
    def rules(self) -> tuple[str, ...]:
        return (
            *WIRE_RULES,
            *outputs.RULES,
            *encoder_edges.RULES,
            *echoes.RULES,
            *ticks.RULES,
            *ticks.RT_RULES,
            *stops.RULES,
            *motor_off_ground.RULES,
        )

    @property
    def pins(self) -> tuple[tuple[int, int], ...]:
        return tuple((wire.output, wire.input) for wire in self.wires)

    @property
    def topics(self) -> Mapping[str, tuple[str, ...]]:
        questions = {topic: tuple(choices) for topic, (_, choices) in motor_off_ground.QUESTIONS.items()}
        return {"wires": ("ready", "skip"), "lift": ("ready", "skip"), **questions}

    def describe_board(self) -> Mapping[str, str]:
        libraries = {name: find_version(name) for name in LIBRARIES}
        return {"model": read_model(self._root), **{name: each for name, each in libraries.items() if each}}

    def run(self, person: LoopbackPerson, write: Callable[[str], object]) -> Generator[RuleResult, None, None]:
        wires, has_failed_stop = " and ".join(map(str, self.wires)), False
        if not person.confirm("wires", WIRES_INSTRUCTION.format(wires=wires)):
            reason = "the wires were not connected"
            yield from (RuleResult.skip(rule, reason) for rule in self.rules[: -len(motor_off_ground.RULES)])
        else:
            with ExitStack() as released:
                released.callback(release_low, self.wires)
                for result in self._measure_over_wires(write):
                    has_failed_stop |= result.rule in stops.RULES and result.verdict is Verdict.FAILED
                    yield result
        if self._motor and has_failed_stop:
            yield from (RuleResult.skip(rule, motor_off_ground.FAILED_STOP_REASON) for rule in motor_off_ground.RULES)
        else:
            reference = self._request.robot_reference
            yield from motor_off_ground.check_motor(self._motor, reference, person, write)

    def _measure_over_wires(self, write: Callable[[str], object]) -> Iterator[RuleResult]:
        problem = lost = ""
        for wire in self.wires:
            found = self._find_problem(wire, is_searching_pins=True)
            yield RuleResult.from_measurement(
                f"wire-{wire.number}", found or "connected", "connected", is_met=not found, reason=found
            )
            problem = problem or found
        with TemporaryDirectory(prefix="loopback-") as folder:
            for rules, measure in self._list_steps(Path(folder), write):
                if problem:
                    yield from (RuleResult.skip(rule, problem) for rule in rules)
                elif lost:
                    yield from (RuleResult.fail(rule, f"a wire was lost: {lost}") for rule in rules)
                else:
                    yield from self._measure_step(rules, measure)
                    lost = next(filter(None, map(self._find_problem, self.wires)), "")

    def _list_steps(self, folder: Path, write: Callable[[str], object]) -> Iterator[tuple[tuple[str, ...], Measure]]:
        levels, pwm = outputs.RULES[:2], outputs.RULES[2:]
        for rules, measure in (
            (levels, outputs.measure_levels),
            (pwm, outputs.measure_pwm),
            (encoder_edges.RULES, encoder_edges.measure_encoders),
            (echoes.RULES, echoes.measure_echoes),
        ):
            write(f"{rules[0]} to {rules[-1]}")
            yield rules, partial(self._measure_with_pins, measure)
        seconds = self._request.tick_test_s
        timed = partial(ticks.measure_ticks, self.wires, folder, seconds, write)
        yield ticks.RULES, partial(timed, is_real_time=False)
        if self._request.is_real_time:
            yield ticks.RT_RULES, partial(timed, is_real_time=True)
        else:
            yield ticks.RT_RULES, lambda: (RuleResult.skip(rule, NO_RT) for rule in ticks.RT_RULES)
        yield stops.RULES, partial(stops.measure_stops, self.wires, folder, write)

    def _measure_with_pins(self, measure: Callable[..., Iterator[RuleResult]]) -> Iterator[RuleResult]:
        with closing(open_pins()) as pins:
            yield from measure(self.wires, pins)

    def _measure_step(self, rules: tuple[str, ...], measure: Measure) -> Iterator[RuleResult]:
        """Yield the results of a step. Its rules without a result fail, such as after a failure of a device."""
        done = set()
        try:
            for result in measure():
                done.add(result.rule)
                yield result
        except (DeviceError, BackendError) as error:
            yield from (RuleResult.fail(rule, str(error)) for rule in rules if rule not in done)
        else:
            yield from (
                RuleResult.fail(rule, "the step ended without a result. Run the test again")
                for rule in rules
                if rule not in done
            )

    def _find_problem(self, wire: LoopbackWire, *, is_searching_pins: bool = False) -> str:
        ends = {gpio for each in self.wires for gpio in (each.output, each.input)}
        others = [gpio for gpio in GPIOS if gpio not in (*self._used, *RESERVED, wire.output, wire.input)]
        try:
            with closing(open_pins()) as pins:
                return find_problem(
                    wire, pins, sorted(others, key=lambda gpio: gpio not in ends) if is_searching_pins else ()
                )
        except DeviceError as error:
            return str(error).partition(": ")[2]


def release_low(wires: tuple[LoopbackWire, ...]) -> None:
    """Pull every pin of the wires low, and release it. A pin that another program holds is left out."""
    chip = Chip()
    try:
        for gpio in (gpio for wire in wires for gpio in (wire.output, wire.input)):
            with suppress(BackendError):
                chip.claim_low([gpio])
    finally:
        chip.close()
