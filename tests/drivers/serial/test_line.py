from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
from serial.tools import list_ports

from drivers.serial import line as line_module
from drivers.serial import port
from drivers.serial.line import BITS_PER_BYTE, FIRST_RETRY_S, OUTDATED_S, RECOVERY_S, SUSPENDED_S, Line, Waker
from drivers.serial.line import PERIOD_S as LINE_PERIOD_S
from drivers.serial.port import PortMissingError
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_process
from tests.doubles.serial.board import PERIOD_S, Powered
from tests.doubles.serial.line import AnsweringBoard, NumberingProtocol, PollingProtocol, Wire
from tests.doubles.serial.pty import Pty
from tests.texts import Raises


@pytest.fixture
def pty(tmp_path: Path) -> Iterator[Pty]:
    with Pty(tmp_path) as pty:
        yield pty


class Bench:
    """A line to a board, in simulated time."""

    def __init__(self, pty: Pty, baud: int = 115200) -> None:
        self.clock = SteppedClock(20.0, lambda _steps: None, PERIOD_S)
        self.pty, self.board, self.protocol = pty, AnsweringBoard(), PollingProtocol(baud)
        self.powered = Powered(self.board, pty, self.clock)
        self.line = Line(str(pty.path), self.protocol, self.clock)

    def open(self) -> Bench:
        self.line.open("wheel", 1.0)
        return self

    def pass_time(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    def lose(self) -> None:
        self.pty.unplug()
        self.pass_time(2 * PERIOD_S)


@pytest.fixture
def bench(pty: Pty) -> Iterator[Bench]:
    bench = Bench(pty)
    yield bench
    bench.line.close()


def test_the_last_word_is_sent_in_closing(bench: Bench, pty: Pty) -> None:
    bench.open().protocol.set_word(b"stop")
    bench.line.close()
    assert pty.read_all() == b"stop"


def test_a_command_without_acknowledgement_is_an_error_with_the_time_out(bench: Bench, raises: Raises) -> None:
    bench.open().board.is_deaf = True
    bench.protocol.set_word(b"stop")
    with raises(DeviceError, "not-acknowledged", device="wheel"):
        bench.line.settle("wheel")


def test_a_lost_port_is_reopened_and_its_protocol_reset(bench: Bench) -> None:
    bench.open().lose()
    bench.protocol.set_word(b"old")
    bench.pty.plug_in()
    bench.pass_time(2 * FIRST_RETRY_S)
    bench.line.require("wheel")
    assert bench.board.received == b"??"


def test_a_lost_port_is_reopened_with_growing_pauses(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.open().lose()
    tried: list[float] = []

    def find_no_path(place: str) -> str:
        tried.append(bench.clock.now())
        raise PortMissingError(place)

    monkeypatch.setattr(port, "find_path", find_no_path)
    bench.pass_time(6.0)
    gaps = [after - before for before, after in pairwise(tried)]
    assert gaps == pytest.approx([0.2, 0.4, 0.8, 1.6, 2.0], abs=2 * PERIOD_S)


def test_an_exception_in_the_protocol_closes_the_line(bench: Bench, raises: Raises) -> None:
    bench.open().protocol.defect = KeyError("side")
    bench.pass_time(1.0)
    with raises(DeviceError, "protocol-defect", device="wheel") as caught:
        bench.line.require("wheel")
    assert isinstance(caught.value.__cause__, KeyError)
    assert not isinstance(caught.value, DeviceLostError)


def test_an_interrupted_opening_leaves_no_file_open(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    before = _open_files()
    bench.board.is_deaf = True

    def ctrl_c(_time: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(bench.clock, "sleep_until", ctrl_c)
    with pytest.raises(KeyboardInterrupt):
        bench.open()
    assert _open_files() == before


HOLDING = """
import sys
from serial import Serial
port = Serial(sys.argv[1], exclusive=True)
print("held", flush=True)
sys.stdin.read()
"""


def test_a_port_that_another_program_holds_is_refused_by_path_and_by_usb_id(
    pty: Pty, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    there = SimpleNamespace(device=str(pty.path), vid=0x1A86, pid=0x7523, serial_number=None)
    monkeypatch.setattr(list_ports, "comports", lambda: [there])
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", HOLDING, pty.path], stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        program.stdout.readline()
        for place in (str(pty.path), "usb:1a86:7523"):
            with raises(DeviceError, "port-not-opened", device="wheel", hide=[describe_process(program.pid)]):
                Line(place, PollingProtocol(), MonotonicClock()).open("wheel", 1.0)
        program.communicate()


def test_a_board_that_does_not_read_is_an_error_and_delays_nothing(pty: Pty, raises: Raises) -> None:
    bench = Bench(pty, baud=4_000_000).open()
    bench.powered.off()
    bench.protocol.set_word(b"x" * 50_000)
    bench.pass_time(PERIOD_S)
    with raises(DeviceLostError, "port-lost", device="wheel"):
        bench.line.require("wheel")
    bench.line.close()


@pytest.mark.parametrize("baud", [9600, 57600, 115200])
def test_only_the_newest_command_is_sent_and_no_more_than_the_baud_rate_allows(pty: Pty, baud: int) -> None:
    clock, wire, protocol = SteppedClock(1000, lambda _steps: None), Wire(), NumberingProtocol(baud)
    Powered(wire, pty, clock)
    line = Line(str(pty.path), protocol, clock)
    line.open("wheel", 1.0)
    period_s, turn_s, frame_s = 0.005, 2 * LINE_PERIOD_S, Wire.SIZE * BITS_PER_BYTE / baud
    set_at: dict[int, float] = {}
    while clock.now() < 2.0:
        set_at[number := len(set_at) + 1] = clock.now()
        protocol.set(number, clock.now())
        clock.sleep_until(clock.now() + period_s)
    line.close()
    numbers = [frame.number for frame in wire.received]
    assert numbers == sorted(set(numbers)), "none is sent twice, or after a newer one"
    for frame, after in pairwise(wire.received):
        assert after.at - frame.at >= frame_s - turn_s, "none waits for another one on the wire"
        newest = max(number for number, at in set_at.items() if at <= frame.at - turn_s - LINE_PERIOD_S or number == 1)
        assert frame.number >= newest
    assert len(numbers) >= 0.95 * 2.0 / max(period_s, frame_s + LINE_PERIOD_S), "the line is never idle"


@pytest.fixture
def clock() -> Iterator[MonotonicClock]:
    clock = MonotonicClock()
    yield clock
    clock.close()


class RealTimeBench:
    """A line to a board, with a thread of its own."""

    def __init__(self, pty: Pty, clock: MonotonicClock) -> None:
        self.pty, self.clock, self.board, self.protocol = pty, clock, AnsweringBoard(), PollingProtocol()
        self.powered = Powered(self.board, pty, clock)
        self.line = Line(str(pty.path), self.protocol, clock)
        self.line.open("wheel", 5.0)

    def wait_until(self, condition: Callable[[], bool]) -> None:
        self.line.wait_until(condition, "wheel", 5.0, lambda: "it never happened")

    def require_often(self) -> None:
        for _ in range(5000):
            self.line.require("wheel")
            self.clock.sleep_until(self.clock.now() + 0.001)

    def close(self) -> None:
        self.line.close()
        self.powered.off()


@pytest.fixture
def real(pty: Pty, clock: MonotonicClock) -> Iterator[RealTimeBench]:
    bench = RealTimeBench(pty, clock)
    yield bench
    bench.close()


def test_in_real_time_a_board_is_ready_then_lost_then_ready_again(real: RealTimeBench) -> None:
    real.protocol.set_word(b"go")
    real.line.wake()
    real.wait_until(lambda: real.protocol.is_settled)
    real.pty.unplug()
    with pytest.raises(DeviceLostError):
        real.require_often()
    real.pty.plug_in()
    real.wait_until(lambda: real.board.received == b"?go?" and real.protocol.is_ready)
    real.protocol.set_word(b"stop")
    real.close()
    assert real.board.received + real.pty.read() == b"?go?stop"


@pytest.mark.slow
def test_a_board_that_was_lost_while_the_program_was_suspended_is_not_reported_as_silent(
    real: RealTimeBench, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    wait = Waker.wait

    def wait_suspended(waker: Waker, file: int | None, seconds: float) -> None:
        wait(waker, file, seconds)
        if real.protocol.is_ready:
            real.clock.sleep_until(real.clock.now() + 2 * SUSPENDED_S)
            real.protocol.is_lost = True

    real.powered.off()
    monkeypatch.setattr(Waker, "wait", wait_suspended)
    with raises(DeviceLostError, "program-suspended", device="wheel", hide=["0.6 s", "0.7 s"]):
        real.require_often()
    real.clock.sleep_until(real.clock.now() + RECOVERY_S)
    with pytest.raises(DeviceLostError):
        real.line.require("wheel")


@pytest.mark.parametrize("has_line_run", [False, True])
def test_a_sample_from_before_a_suspension_is_not_reported_as_old(
    bench: Bench, raises: Raises, *, has_line_run: bool
) -> None:
    sample_time = bench.open().clock.now()
    bench.line._exchanged_at -= 2 * OUTDATED_S
    if has_line_run:
        bench.pass_time(PERIOD_S)
    with raises(DeviceLostError, "program-suspended", device="wheel", hide=["1.0 s"]):
        bench.line.require_since_lost("wheel", sample_time)
    bench.pass_time(RECOVERY_S)
    bench.line.require_since_lost("wheel", bench.clock.now())


def test_data_with_a_due_time_is_sent_on_time_during_another_wait(
    real: RealTimeBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patient:
        patient.setattr(line_module, "MAX_WAIT_S", 1000.0)
        real.protocol.set_word(b"go", at=real.clock.now() + 0.05)
        real.line.wake()
        real.wait_until(lambda: real.protocol.is_settled)
    real.line.wake()
    assert real.board.received == b"?go"


def test_a_closed_line_waits_without_using_the_processor(real: RealTimeBench, monkeypatch: pytest.MonkeyPatch) -> None:
    waits, wait = list[float](), Waker.wait

    def record_wait(waker: Waker, file: int | None, seconds: float) -> None:
        waits.extend([seconds] if file is None else [])
        wait(waker, file, seconds)

    monkeypatch.setattr(Waker, "wait", record_wait)
    real.protocol.defect = KeyError("side")
    real.clock.sleep_until(real.clock.now() + 2 * FIRST_RETRY_S)
    assert waits
    assert min(waits) > 0


def test_nothing_is_left_open(pty: Pty, clock: MonotonicClock) -> None:
    before = _open_files()
    for _ in range(3):
        bench = RealTimeBench(pty, clock)
        bench.close()
        bench.line.close()
    assert _open_files() == before


def _open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))
