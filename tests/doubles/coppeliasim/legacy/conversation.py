"""What is said with one client, apart from any socket: every message is answered at once with what is ready by then.

So a command's reply comes with the answer to the client's *next* message: a call takes two messages. The maker's
server is the same (``simxSocket.cpp``): its thread of communication answers, its main loop executes, in between.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tests.doubles.coppeliasim.legacy.codec import Command, Header, pack, unpack
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.inbox import Inbox

NOTHING_NEW = -1
"""The number of a reply that holds nothing that was executed since the last one."""


class Conversation:
    """One client's messages, and the replies that wait for its next one. ``is_over`` once it has said goodbye."""

    def __init__(self) -> None:
        self._inbox = Inbox()
        self._heard = Header(NOTHING_NEW, 0)
        self._reply = self._heard
        self._done: list[Command] = []
        self.is_over = False

    def receive(self, message: bytes) -> bytes:
        """Take in a client's message; return the answer to it. Raises ProtocolError where it is none."""
        self._heard, commands = unpack(message)
        for command in commands:
            self._inbox.put(command)
        self.is_over = any(command.code == Code.KILL_CONNECTION for command in commands)
        answer = pack(self._reply, self._done)
        self._done = []
        return answer

    def execute(self, execute: Callable[[Command], Command], now_ms: int, state: int) -> None:
        """Execute what waits, and keep the replies for the next message; ``state`` is what headers tell of a run."""
        self._reply = replace(self._heard, server_ms=now_ms, scene=0, state=state)
        self._done = self._inbox.execute(execute, now_ms)
