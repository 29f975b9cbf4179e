"""Commands to a board and its answers, by pyserial without a driver."""

from __future__ import annotations

from types import TracebackType

from serial import Serial

from tests.system.firmware.board import Board

BAUD = 57600
ANSWER_S = 0.5
TRY_S = 0.05
BOOTING_S = 3.0


class RawLine:
    """Opens a board's line, and waits until the board accepts commands."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._serial = Serial(str(board.port), BAUD, timeout=0.02)
        board.wait(lambda: self.ask("b", TRY_S) == str(BAUD), "the firmware's first answer", BOOTING_S)
        board.pass_time(TRY_S)
        self._serial.reset_input_buffer()

    def ask(self, command: str, within_s: float = ANSWER_S) -> str:
        """Send a command, and return the answer; empty without one in ``within_s`` seconds of the AVR's time."""
        self.send(f"{command}\r".encode())
        return self.read_answer(within_s)

    def send(self, data: bytes) -> None:
        self._serial.write(data)

    def read_answer(self, within_s: float = ANSWER_S) -> str:
        """Return the next line, or after ``within_s`` seconds the part of the line that has arrived."""
        end, got = self._board.now() + within_s, b""
        while not got.endswith(b"\n") and self._board.now() < end:
            got += self._serial.readline()
        return got.decode("ascii", "replace").strip()

    def close(self) -> None:
        self._serial.close()

    def __enter__(self) -> RawLine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
