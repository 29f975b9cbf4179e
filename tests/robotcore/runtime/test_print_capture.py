from __future__ import annotations

import contextlib
import io
import os
import sys
import threading
from collections.abc import Generator
from pathlib import Path
from typing import TextIO

import pytest

from robotcore.autonomy.routines import Routine
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.print_capture import BURST_CHARACTERS, CHARACTERS_PER_TICK, MORE, PrintCapture
from robotcore.runtime.session import RunRequest, run
from robotcore.testing.mock.robot import MockRobot
from tests.robotcore.fakes import FunctionApp


def write(*texts: str) -> None:
    """Write texts to the present stdout, as ``print`` does."""
    for text in texts:
        sys.stdout.write(text)


def test_prints_reach_the_terminal_unchanged_and_are_copied_as_lines() -> None:
    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints = PrintCapture()
        with prints:
            write("a", " ", "b", "\n", "\n")
            sys.stdout.writelines(["c\r\n", "\udc80 without an end"])
        assert sys.stdout is terminal
        assert terminal.getvalue() == "a b\n\nc\r\n\udc80 without an end"
        assert prints.take() == ("a b", "c", "\\udc80 without an end")
        assert prints.take() == ()


def test_stream_within_the_block_has_the_attributes_of_the_terminal(tmp_path: Path) -> None:
    with (tmp_path / "out").open("w", encoding="latin-1") as stream, contextlib.redirect_stdout(stream):
        with PrintCapture():
            assert sys.stdout.encoding == "latin-1"
            assert sys.stdout.fileno() == stream.fileno()
            assert sys.stdout.buffer is stream.buffer
            assert not hasattr(sys.stdout, "no_such_attribute")
        assert sys.stdout is stream


def test_stream_that_the_app_sets_stays_set() -> None:
    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints, other = PrintCapture(), io.StringIO()
        with prints:
            sys.stdout = other
        assert sys.stdout is other
        with prints:
            write("to the other")
        assert (terminal.getvalue(), other.getvalue()) == ("", "to the other")
        assert prints.take() == ("to the other",)


def test_stream_that_the_app_puts_around_stdout_gets_each_text_once() -> None:
    class Loud(io.StringIO):
        def __init__(self, inner: TextIO) -> None:
            super().__init__()
            self.inner = inner

        def write(self, text: str) -> int:
            return self.inner.write(text.upper())

    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints = PrintCapture()
        with prints:
            sys.stdout = Loud(sys.stdout)
        for _ in range(2):
            with prints:
                write("a\n")
        assert terminal.getvalue() == "A\nA\n"
        assert prints.take() == ("a", "a")


def test_block_of_the_app_over_several_ticks_may_replace_stdout_in_each_of_them() -> None:
    def print_into_a_text() -> Generator[None, None, None]:
        while True:
            with contextlib.redirect_stdout(io.StringIO()):
                write("hidden\n")
                yield
            write("shown\n")

    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints, app = PrintCapture(), print_into_a_text()
        for _ in range(2 * sys.getrecursionlimit()):
            with prints:
                next(app)
            taken = prints.take()
        assert taken == ("shown",)
        app.close()
        assert terminal.getvalue().count("shown") == 2 * sys.getrecursionlimit() - 1
        with prints:
            pass
        assert sys.stdout is terminal


def test_print_fails_as_without_a_copy_if_the_terminal_is_gone() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    prints = PrintCapture()
    with (
        contextlib.suppress(BrokenPipeError),
        os.fdopen(writer, "w", buffering=1) as stream,
        contextlib.redirect_stdout(stream),
        prints,
        pytest.raises(BrokenPipeError),
    ):
        write("lost\n")
    assert prints.take() == ()


def test_process_without_stdout_has_no_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    prints = PrintCapture()
    with prints:
        print("nowhere")  # noqa: T201  ``print`` ignores that there is no stdout
    assert prints.take() == ()


def test_prints_of_other_threads_and_after_the_block_are_not_copied() -> None:
    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints = PrintCapture()
        with prints:
            kept = sys.stdout
            thread = threading.Thread(target=write, args=["of a thread\n"])
            thread.start()
            thread.join()
        kept.write("later\n")
        assert terminal.getvalue() == "of a thread\nlater\n"
        assert prints.take() == ()


def test_copies_are_limited_and_the_terminal_gets_everything() -> None:
    with contextlib.redirect_stdout(io.StringIO()) as terminal:
        prints, taken, line = PrintCapture(), list[tuple[str, ...]](), "x" * 99 + "\n"
        for _ in range(5):
            with prints:
                for _ in range(1000):
                    write(line)
                assert sys.stdout is terminal
            taken.append(prints.take())
        assert terminal.getvalue() == 5_000 * line
        assert [len("".join(lines[:-1])) for lines in taken] == [
            BURST_CHARACTERS - BURST_CHARACTERS // 100,
            *[CHARACTERS_PER_TICK - CHARACTERS_PER_TICK // 100] * 4,
        ]
        assert {lines[-1] for lines in taken} == {MORE}
        for _ in range(BURST_CHARACTERS // CHARACTERS_PER_TICK):
            assert prints.take() == ()
        with prints:
            write(line)
        assert prints.take() == (line.strip(),)


def test_record_of_a_tick_has_the_lines_that_the_app_printed(capsys: pytest.CaptureFixture[str]) -> None:
    count = iter(range(9))

    def step(_: Robot) -> Status:
        write(f"tick {next(count)}\n")
        return Status.RUNNING

    robot = MockRobot()
    robot.run(FunctionApp(step), ticks=2)
    assert [tick.printed for tick in robot.ticks] == [("tick 0",), ("tick 1",)]
    assert capsys.readouterr().out == "tick 0\ntick 1\n"


def test_prints_of_a_routine_and_its_clean_up_are_in_its_ticks() -> None:
    class Printing(Behaviour):
        def run(self, robot: Robot) -> Routine[Status]:
            try:
                write("begins\n")
                yield
                yield
            finally:
                write("ends\n")
            return Status.SUCCESS

    lines = list[tuple[str, ...]]()

    class Watcher:
        begin = end = staticmethod(lambda _: None)
        tick = staticmethod(lambda record: lines.append(record.printed))

    run(RunRequest(Printing, timeout_s=0.05), [Watcher()])
    assert lines == [("begins",), ("ends",)]
