"""The queues of one client. Commands wait for the next turn of the main loop, and answers for the next message."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Header, Mode, ProtocolError, is_repeated, pack, unpack

KEEP_BOTH = 1


class _Waiting:
    """A command and the time of its last execution. A stream with a delay is not executed in each turn."""

    def __init__(self, command: Command) -> None:
        self.command = command
        self._executed_ms: int | None = None

    def is_due(self, now_ms: int) -> bool:
        if self._executed_ms is not None and now_ms - self._executed_ms < self.command.delay_ms:
            return False
        self._executed_ms = now_ms
        return True


class Inbox:
    """The commands of one client, in the order of execution."""

    def __init__(self) -> None:
        self._waiting: list[_Waiting] = []

    def put(self, command: Command) -> None:
        """Add a command. It replaces a command with the same number and identity, unless its status keeps both.

        So a command that ends a stream has the stream's place in the order.
        """
        if command.mode in {Mode.ONESHOT_SPLIT, Mode.STREAMING_SPLIT}:
            raise ProtocolError(f"command {command.code} in a split mode, which the double does not serve")
        for index, each in enumerate(self._waiting):
            same = (each.command.code, each.command.identity) == (command.code, command.identity)
            if same and not command.status & KEEP_BOTH:
                self._waiting[index] = _Waiting(command)
                return
        self._waiting.append(_Waiting(command))

    def execute(self, execute: Callable[[Command], Command], now_ms: int) -> list[Command]:
        """Execute the due commands, and return their answers. Only streams remain in the inbox.

        A command that ends a stream is returned unchanged.
        """
        replies = []
        for each in self._waiting:
            if each.command.mode == Mode.DISCONTINUE:
                replies.append(Command(each.command.code, each.command.mode, each.command.identity))
            elif each.is_due(now_ms):
                replies.append(execute(each.command))
        self._waiting = [each for each in self._waiting if is_repeated(each.command.mode)]
        return replies


NOTHING_EXECUTED = -1
"""The message number in a reply if no message was executed since the previous reply."""


class Conversation:
    """The messages of one client, and the replies that wait for its next message.

    ``is_over`` is True after the client's last message.
    """

    def __init__(self) -> None:
        self._inbox = Inbox()
        self._received = Header(NOTHING_EXECUTED, 0)
        self._reply = self._received
        self._answers: list[Command] = []
        self.is_over = False

    def receive(self, message: bytes) -> bytes:
        """Receive a message, and return the reply. Raises ProtocolError if the message is invalid."""
        self._received, commands = unpack(message)
        for command in commands:
            self._inbox.put(command)
        self.is_over = any(command.code == Code.KILL_CONNECTION for command in commands)
        answer = pack(self._reply, self._answers)
        self._answers = []
        return answer

    def execute(self, execute: Callable[[Command], Command], now_ms: int, state: int) -> None:
        """Execute the due commands, and store the answers for the next reply, whose header contains ``state``."""
        self._reply = replace(self._received, server_ms=now_ms, scene=0, state=state)
        self._answers = self._inbox.execute(execute, now_ms)
