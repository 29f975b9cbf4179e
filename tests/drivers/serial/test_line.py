from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
from serial.tools import list_ports

from drivers.serial import line as line_module
from drivers.serial.line import FIRST_RETRY_S, RECOVERY_S, SUSPENDED_S, Line, Waker
from drivers.serial.port import describe_ports
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_process
from tests.doubles.serial.board import PERIOD_S, Powered
from tests.doubles.serial.line import AnsweringBoard, PollingProtocol
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


def test_a_line_sends_due_data_and_receives(bench: Bench) -> None:
    bench.open()
    bench.protocol.set_word(b"go")
    bench.line.settle("wheel")
    assert bench.board.received == b"?go"


def test_the_last_word_is_sent_in_closing(bench: Bench, pty: Pty) -> None:
    bench.open().protocol.set_word(b"stop")
    bench.line.close()
    assert pty.read_all() == b"stop"


def test_a_command_without_acknowledgement_is_an_error_with_the_time_out(bench: Bench, raises: Raises) -> None:
    bench.open().board.is_deaf = True
    bench.protocol.set_word(b"stop")
    with raises(DeviceError, "not-acknowledged", device="wheel"):
        bench.line.settle("wheel")


def test_the_line_sends_no_more_than_its_baud_rate_allows(pty: Pty) -> None:
    bench = Bench(pty, baud=300).open()
    bench.board.times.clear()
    for _ in range(3):
        bench.protocol.set_word(b"123")
        bench.line.settle("wheel")
    bench.line.close()
    gaps = [after - before for before, after in pairwise(bench.board.times)]
    assert gaps == pytest.approx([0.1, 0.1], abs=2 * PERIOD_S)


def test_a_lost_port_is_an_error_with_the_time_out(bench: Bench, raises: Raises) -> None:
    bench.open().lose()
    with raises(DeviceLostError, "port-lost", device="wheel"):
        bench.line.require("wheel")


def test_a_lost_port_is_reopened_and_its_protocol_reset(bench: Bench) -> None:
    bench.open().lose()
    bench.protocol.set_word(b"old")
    bench.pty.plug_in()
    bench.pass_time(2 * FIRST_RETRY_S)
    bench.line.require("wheel")
    assert bench.board.received == b"??"


def test_a_reopened_port_is_lost_until_its_board_answers(bench: Bench, raises: Raises) -> None:
    bench.open().lose()
    bench.board.is_deaf = True
    bench.pty.plug_in()
    bench.pass_time(2 * FIRST_RETRY_S)
    with raises(DeviceLostError, "board-silent", device="wheel"):
        bench.line.require("wheel")


def test_a_sample_from_before_a_loss_is_not_read_after_it(bench: Bench, raises: Raises) -> None:
    bench.open()
    heard_at = bench.clock.now()
    bench.line.require_since_lost("wheel", heard_at)
    bench.lose()
    bench.pty.plug_in()
    bench.pass_time(2 * FIRST_RETRY_S)
    bench.line.require("wheel")
    with raises(DeviceLostError, "no-sample-yet", device="wheel"):
        bench.line.require_since_lost("wheel", heard_at)
    bench.line.require_since_lost("wheel", bench.clock.now())


def test_a_lost_port_is_reopened_with_growing_pauses(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.open().lose()
    tried: list[float] = []

    def is_there(_path: Path) -> bool:
        tried.append(bench.clock.now())
        return False

    monkeypatch.setattr(Path, "exists", is_there)
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


def test_a_port_without_an_answer_is_refused(bench: Bench, raises: Raises) -> None:
    bench.board.is_deaf = True
    with raises(DeviceError, "board-silent", device="wheel"):
        bench.open()


def test_an_interrupted_opening_leaves_no_file_open(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    before = _open_files()
    bench.board.is_deaf = True

    def ctrl_c(_time: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(bench.clock, "sleep_until", ctrl_c)
    with pytest.raises(KeyboardInterrupt):
        bench.open()
    assert _open_files() == before


def test_a_missing_port_is_refused_with_a_list_of_the_ports(tmp_path: Path, raises: Raises) -> None:
    line = Line(str(tmp_path / "none"), PollingProtocol(), MonotonicClock())
    with raises(DeviceError, "port-not-opened", device="wheel", hide=[describe_ports()]):
        line.open("wheel", 1.0)


def test_a_file_that_is_no_port_is_refused(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "file"
    file.touch()
    with raises(DeviceError, "port-not-opened", device="wheel"):
        Line(str(file), PollingProtocol(), MonotonicClock()).open("wheel", 1.0)


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


class TestByAThread:
    """In real time."""

    @pytest.fixture
    def clock(self) -> Iterator[MonotonicClock]:
        clock = MonotonicClock()
        yield clock
        clock.close()

    def test_a_board_is_ready_then_lost_then_ready_again(self, pty: Pty, clock: MonotonicClock) -> None:
        protocol, board = PollingProtocol(), AnsweringBoard()
        powered = Powered(board, pty, clock)
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 5.0)
        protocol.set_word(b"go")
        line.wake()
        line.wait_until(lambda: protocol.is_settled, "wheel", 5.0, lambda: "was never heard")
        pty.unplug()
        with pytest.raises(DeviceLostError):
            _require_often(line, clock)
        pty.plug_in()
        line.wait_until(
            lambda: board.received == b"?go?" and protocol.is_ready, "wheel", 5.0, lambda: "never came back"
        )
        protocol.set_word(b"stop")
        line.close()
        powered.off()
        assert board.received + pty.read() == b"?go?stop"

    @pytest.mark.slow
    def test_a_board_that_was_lost_while_the_program_was_suspended_is_not_reported_as_silent(
        self, pty: Pty, clock: MonotonicClock, monkeypatch: pytest.MonkeyPatch, raises: Raises
    ) -> None:
        protocol, wait = PollingProtocol(), Waker.wait

        def wait_suspended(waker: Waker, file: int | None, seconds: float) -> None:
            wait(waker, file, seconds)
            if protocol.is_ready:
                clock.sleep_until(clock.now() + 2 * SUSPENDED_S)
                protocol.is_lost = True

        powered = Powered(AnsweringBoard(), pty, clock)
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 5.0)
        powered.off()
        monkeypatch.setattr(Waker, "wait", wait_suspended)
        with raises(DeviceLostError, "program-suspended", device="wheel", hide=["0.6 s", "0.7 s"]):
            _require_often(line, clock)
        clock.sleep_until(clock.now() + RECOVERY_S)
        with pytest.raises(DeviceLostError):
            line.require("wheel")
        line.close()

    def test_data_with_a_due_time_is_sent_on_time_during_another_wait(
        self, pty: Pty, clock: MonotonicClock, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        protocol, board = PollingProtocol(), AnsweringBoard()
        powered = Powered(board, pty, clock)
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 5.0)
        with monkeypatch.context() as patient:
            patient.setattr(line_module, "MAX_WAIT_S", 1000.0)
            protocol.set_word(b"go", at=clock.now() + 0.05)
            line.wake()
            line.wait_until(lambda: protocol.is_settled, "wheel", 5.0, lambda: "was never heard")
        line.wake()
        line.close()
        powered.off()
        assert board.received == b"?go"

    def test_a_freed_line_waits(self, pty: Pty, clock: MonotonicClock, monkeypatch: pytest.MonkeyPatch) -> None:
        protocol, waits, wait = PollingProtocol(), list[float](), Waker.wait

        def record_wait(waker: Waker, file: int | None, seconds: float) -> None:
            waits.extend([seconds] if file is None else [])
            wait(waker, file, seconds)

        powered = Powered(AnsweringBoard(), pty, clock)
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 5.0)
        monkeypatch.setattr(Waker, "wait", record_wait)
        protocol.defect = KeyError("side")
        clock.sleep_until(clock.now() + 2 * FIRST_RETRY_S)
        line.close()
        powered.off()
        assert waits
        assert min(waits) > 0

    def test_nothing_is_left_open(self, pty: Pty, clock: MonotonicClock) -> None:
        before = _open_files()
        powered = Powered(AnsweringBoard(), pty, clock)
        for _ in range(3):
            line = Line(str(pty.path), PollingProtocol(), clock)
            line.open("wheel", 5.0)
            line.close()
            line.close()
        powered.off()
        assert _open_files() == before


def _require_often(line: Line, clock: MonotonicClock) -> None:
    for _ in range(5000):
        line.require("wheel")
        clock.sleep_until(clock.now() + 0.001)


def _open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))
