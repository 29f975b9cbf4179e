from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore.hardware.firmware import board, toolchain
from tests.doubles.serial.pty import Pty
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.hardware.firmware.tools import COMPILES, LISTS_CORE, Tools


class AnsweringBoard:
    """A board at the end of a pty: it answers each line by what ``says`` has, and is deaf while it boots."""

    def __init__(self, pty: Pty, says: bytes, deaf_lines: int = 0) -> None:
        self._pty, self._says, self._deaf = pty, says, deaf_lines
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._leaving.is_set():
            for _ in range(self._pty.heard(0.02).count(b"\r")):
                self._deaf -= 1
                if self._deaf < 0:
                    self._pty.say(self._says)

    def close(self) -> None:
        self._leaving.set()
        self._thread.join()


@pytest.fixture
def pty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Pty]:
    monkeypatch.setattr(board, "BOOTING_S", 0.0)
    monkeypatch.setattr(board, "BETWEEN_S", 0.05)
    pty = Pty(tmp_path)
    yield pty
    pty.unplug()


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tools:
    monkeypatch.setattr(toolchain, "AVR_CORE", tmp_path / "nowhere")
    tools = Tools(tmp_path, monkeypatch)
    tools.put("arduino-cli", LISTS_CORE + COMPILES)
    return tools


@pytest.mark.parametrize("deaf_lines", [0, 2])
def test_flashed_board_tells_what_it_runs(cli: Cli, tools: Tools, pty: Pty, deaf_lines: int) -> None:
    tools.put("avrdude")
    board = AnsweringBoard(pty, b"\xf0noise\r\nrobotcore-bridge 1\r\n", deaf_lines)
    try:
        answer = cli("firmware", "flash", "--board", "nano-old", "--port", str(pty.path))
    finally:
        board.close()
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == (
        f"built robotcore_bridge.ino.hex with arduino-cli: 4 of 30720 bytes\nflashing the nano-old at {pty.path} ...\n"
        f"flashed and verified with avrdude\n{pty.path} answers: robotcore-bridge 1\n"
    )
    flashed = tools.calls[-1]
    assert flashed.startswith(f"avrdude -q -p m328p -c arduino -P {pty.path} -b 57600 -D -U flash:w:/")
    assert flashed.endswith("/robotcore_bridge.ino.hex:i")


@pytest.mark.parametrize("says, shown_as", [(b"", "nothing"), (b"Invalid Command\r\n", "b'Invalid Command'")])
def test_board_that_does_not_answer_as_ours_does_is_no_success(
    cli: Cli, tools: Tools, pty: Pty, says: bytes, shown_as: str
) -> None:
    tools.put("avrdude")
    board = AnsweringBoard(pty, says)
    try:
        answer = cli("firmware", "flash", "--port", str(pty.path))
    finally:
        board.close()
    assert answer.status == 3
    assert f"{pty.path}: was flashed, but asked for its version at 57600 baud it said {shown_as}. Press" in answer.err


def test_avrdude_that_fails_is_quoted_and_the_board_is_not_asked(cli: Cli, tools: Tools, pty: Pty) -> None:
    tools.put("avrdude", "echo 'avrdude: stk500_recv(): programmer is not responding' >&2; exit 1")
    answer = cli("firmware", "flash", "--port", str(pty.path))
    assert (answer.status, pty.heard()) == (3, b"")
    assert "avrdude failed (exit 1). A board that does not respond may have the other bootloader: try " in answer.err
    assert "It said:\n  avrdude: stk500_recv(): programmer is not responding" in answer.err


def test_without_avrdude_arduino_cli_uploads(cli: Cli, tools: Tools, pty: Pty) -> None:
    board = AnsweringBoard(pty, b"robotcore-bridge 1\r\n")
    try:
        answer = cli("firmware", "flash", "--board", "nano", "--port", str(pty.path))
    finally:
        board.close()
    assert "flashed and verified with arduino-cli\n" in answer.out
    called = tools.calls[-1]
    assert called.startswith(f"arduino-cli upload --fqbn arduino:avr:nano --port {pty.path} --verify --input-file /")


def test_what_flashes_is_named_where_there_is_nothing(cli: Cli, tools: Tools, pty: Pty) -> None:
    (pty.path.parent / "bin" / "arduino-cli").unlink()
    answer = cli("firmware", "flash", "--port", str(pty.path))
    assert (answer.status, answer.out) == (3, "")
    assert "nothing here builds for a uno. Install arduino-cli" in answer.err


def test_built_program_is_left_where_it_was_asked_for(cli: Cli, tools: Tools, tmp_path: Path) -> None:
    answer = cli("firmware", "build", "--into", str(tmp_path / "new" / "folder"))
    image = tmp_path / "new" / "folder" / "robotcore_bridge.ino.hex"
    assert answer.out.splitlines()[-1] == str(image)
    assert image.is_file()


def test_copy_tells_which_file_to_edit_and_what_to_do_then(cli: Cli, tmp_path: Path) -> None:
    sketch = tmp_path / "mine" / "robotcore_bridge"
    assert cli("firmware", "copy", str(tmp_path / "mine")) == (
        0,
        f"{sketch}/config.h: say there how your robot is wired\nthen: robotcore firmware flash --sketch-dir {sketch}\n",
        "",
    )


def test_board_that_is_none_is_refused(cli: Cli) -> None:
    answer = cli("firmware", "build", "--board", "mega")
    assert answer.status == 2
    assert "'mega' is not one of 'uno', 'nano', 'nano-old'" in answer.err
