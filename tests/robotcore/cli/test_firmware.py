from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore.hardware.firmware import board
from tests.doubles.serial.pty import Pty
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.hardware.firmware.tools import COMPILES, LISTS_CORE, Tools
from tests.texts import CheckText


class AnsweringBoard:
    """A board at the end of a pty. It ignores ``deaf_lines`` lines, and answers each later line with ``reply``."""

    def __init__(self, pty: Pty, reply: bytes, deaf_lines: int = 0) -> None:
        self._pty, self._reply, self._deaf = pty, reply, deaf_lines
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._leaving.is_set():
            for _ in range(self._pty.read(0.02).count(b"\r")):
                self._deaf -= 1
                if self._deaf < 0:
                    self._pty.send(self._reply)

    def close(self) -> None:
        self._leaving.set()
        self._thread.join()


@pytest.fixture
def pty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Pty]:
    monkeypatch.setattr(board, "BOOT_S", 0.0)
    monkeypatch.setattr(board, "QUESTION_PERIOD_S", 0.05)
    pty = Pty(tmp_path)
    yield pty
    pty.unplug()


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tools:
    tools = Tools(tmp_path, monkeypatch)
    tools.put("arduino-cli", LISTS_CORE + COMPILES)
    return tools


@pytest.mark.parametrize("deaf_lines", [0, 2])
def test_flashed_board_is_asked_for_its_version(
    cli: Cli, tools: Tools, pty: Pty, deaf_lines: int, check_text: CheckText
) -> None:
    board = AnsweringBoard(pty, b"\xf0noise\r\nrobotcore-bridge 1\r\n", deaf_lines)
    try:
        answer = cli("firmware", "flash", "--board", "nano-old", "--port", str(pty.path))
    finally:
        board.close()
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out)
    flashed = tools.calls[-1]
    target = f"--fqbn arduino:avr:nano:cpu=atmega328old --port {pty.path}"
    assert flashed.startswith(f"arduino-cli upload {target} --verify --input-file /")
    assert flashed.endswith("/robotcore_bridge.ino.hex")


@pytest.mark.slow
@pytest.mark.parametrize("reply", [b"", b"Invalid Command\r\n"])
def test_a_board_that_does_not_report_its_version_is_a_failure(
    cli: Cli, tools: Tools, pty: Pty, reply: bytes, check_text: CheckText
) -> None:
    board = AnsweringBoard(pty, reply)
    try:
        answer = cli("firmware", "flash", "--port", str(pty.path))
    finally:
        board.close()
    assert answer.status == 3
    check_text(answer.err)


def test_an_upload_that_fails_is_quoted_and_the_board_is_not_asked(
    cli: Cli, tools: Tools, pty: Pty, check_text: CheckText
) -> None:
    fails = 'upload*) echo "avrdude: stk500_recv(): programmer is not responding" >&2; exit 1;; '
    tools.put("arduino-cli", LISTS_CORE + fails + COMPILES)
    answer = cli("firmware", "flash", "--port", str(pty.path))
    assert (answer.status, pty.read()) == (3, b"")
    check_text(answer.err)


def test_program_is_built_into_the_given_folder(cli: Cli, tools: Tools, tmp_path: Path) -> None:
    answer = cli("firmware", "build", "--into", str(tmp_path / "new" / "folder"))
    image = tmp_path / "new" / "folder" / "robotcore_bridge.ino.hex"
    assert answer.out.splitlines()[-1] == str(image)
    assert image.is_file()


def test_copy_names_the_file_to_edit_and_the_next_command(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    sketch = tmp_path / "mine" / "robotcore_bridge"
    answer = cli("firmware", "copy", str(tmp_path / "mine"))
    assert (answer.status, answer.err) == (0, "")
    assert str(sketch / "config.h") in answer.out
    check_text(answer.out)


def test_unknown_board_is_refused(cli: Cli, check_text: CheckText) -> None:
    answer = cli("firmware", "build", "--board", "mega")
    assert answer.status == 2
    check_text(answer.err)
