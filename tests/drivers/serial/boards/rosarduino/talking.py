"""The conversation with a board as its manual would have it: what was sent, and what was answered."""

from __future__ import annotations

from drivers.serial.boards.rosarduino.board import ArduinoTalk
from drivers.serial.boards.rosarduino.protocol import framed

BAUD = 57600
STEP_S = 0.002

HELLO = b"\rm 0 0\rv*76\rb\r"
OURS = b"OK\r\nrobotcore-bridge 1*5C\r\n57600\r\n"
TRUE = b"Invalid Command\r\nOK\r\nInvalid Command\r\n57600\r\n"


def asked(text: str) -> bytes:
    return framed(text, is_summed=True)


def answered(text: str) -> bytes:
    return framed(text, is_summed=True) + b"\n"


class Conversation:
    """Talks, with the test as the board; ``now`` goes on by a step with each turn."""

    def __init__(self) -> None:
        self.talk = ArduinoTalk(BAUD)
        self.now = 10.0
        self.talk.begin(self.now)

    def sent(self, after: float = STEP_S) -> bytes:
        """Return what is sent next, if anything, after so many seconds."""
        self.now += after
        return self.talk.due(self.now)

    def answer(self, data: bytes) -> None:
        self.now += STEP_S
        self.talk.receive(data, self.now)

    def goes(self, *turns: tuple[bytes, bytes]) -> None:
        """Hold it to a table of frames, sent and answered."""
        for sent, received in turns:
            assert self.sent() == sent
            self.answer(received)

    def meet_ours(self) -> None:
        """Come as far as where our firmware is known, and all but counts has been told."""
        self.goes(
            (HELLO, OURS),
            (asked("m 0 0"), answered("OK")),
            (asked("k 2000"), answered("OK")),
            (asked("e"), answered("0 0")),
        )

    def meet_the_true_one(self) -> None:
        self.goes(
            (HELLO, TRUE),
            (HELLO, TRUE),
            (b"m 0 0\r", b"OK\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"m 0 0\r", b"OK\r\n"),
            (b"e\r", b"0 0\r\n"),
        )

    def tell(self, left: float, right: float) -> None:
        """Tell both motors, as an app does in one tick."""
        self.talk.command.tell("left", left, self.now)
        self.talk.command.tell("right", right, self.now)

    @property
    def angle(self) -> float:
        """What the left wheel has turned, in counts."""
        sample = self.talk.counts["left"].turning.angle(1.0)
        assert sample
        return sample.angle
