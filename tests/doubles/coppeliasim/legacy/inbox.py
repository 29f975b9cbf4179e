"""What a client has asked for and the server is not done with: a command waits until the main loop's next turn."""

from __future__ import annotations

from collections.abc import Callable

from tests.doubles.coppeliasim.legacy.codec import Command, ProtocolError, is_kept
from tests.doubles.coppeliasim.legacy.codes import Mode

KEEP_BOTH = 1


class _Waiting:
    """A command, and when it was last executed: a stream with a delay is not due in every turn."""

    def __init__(self, command: Command) -> None:
        self.command = command
        self._executed_ms: int | None = None

    def is_due(self, now_ms: int) -> bool:
        if self._executed_ms is not None and now_ms - self._executed_ms < self.command.delay_ms:
            return False
        self._executed_ms = now_ms
        return True


class Inbox:
    """The commands of one client, in the order in which they are executed."""

    def __init__(self) -> None:
        self._waiting: list[_Waiting] = []

    def put(self, command: Command) -> None:
        """Take a command in; it takes the place of one with the same number and identity, unless both are to be kept.

        So a discontinue ends a stream where the stream stood.
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
        """Return the replies to all that is due, and forget what is no stream; a discontinue is only sent back."""
        replies = []
        for each in self._waiting:
            if each.command.mode == Mode.DISCONTINUE:
                replies.append(Command(each.command.code, each.command.mode, each.command.identity))
            elif each.is_due(now_ms):
                replies.append(execute(each.command))
        self._waiting = [each for each in self._waiting if is_kept(each.command.mode)]
        return replies
