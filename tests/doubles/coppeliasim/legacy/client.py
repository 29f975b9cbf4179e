"""The server's state for one client: its commands wait for the next turn, and their answers for its next message."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Header, Mode, pack, unpack
from tests.doubles.coppeliasim.legacy.commands import CommandExecutor
from tests.doubles.coppeliasim.scene import Simulator, State

IS_RUNNING, IS_PAUSED = 1, 2
"""Bits of the state in a header. The double never sets the bits of real time and of the edit mode."""

KEEP_BOTH = 1
NOTHING_EXECUTED = -1
"""The message number in a reply if no message was executed since the previous reply."""


@dataclass
class WaitingCommand:
    """A command, and the time of its last execution in ms. A stream with a delay is not executed in each turn."""

    command: Command
    executed_ms: int | None = None

    def is_due(self, now_ms: int) -> bool:
        return self.executed_ms is None or now_ms - self.executed_ms >= self.command.delay_ms


class Client:
    """The server's state for one client. Each caller must hold the simulator's lock.

    ``is_leaving`` is True after the client's last message.
    """

    def __init__(self, simulator: Simulator) -> None:
        self.is_leaving = False
        self._simulator = simulator
        self._executor = CommandExecutor(simulator, self)
        self._waiting: list[WaitingCommand] = []
        self._received = Header(NOTHING_EXECUTED, 0)
        self._reply = self._received
        self._answers: list[Command] = []
        self.turn()

    def receive(self, message: bytes) -> bytes:
        """Receive a message, and return the reply, which contains the answers to earlier messages.

        Raises ProtocolError if the message is invalid.
        """
        self._received, commands = unpack(message)
        for command in commands:
            self._put(command)
        self.is_leaving = any(command.code == Code.KILL_CONNECTION for command in commands)
        answer = pack(self._reply, self._answers)
        self._answers = []
        return answer

    def turn(self) -> None:
        """Execute the received commands, and then the requested time step."""
        now_ms, state = int(time.monotonic() * 1000), self._simulator.state
        bits = IS_RUNNING * (state is not State.STOPPED) | IS_PAUSED * (state is State.PAUSED)
        self._reply = replace(self._received, server_ms=now_ms, scene=0, state=bits)
        self._answers = [self._execute(each, now_ms) for each in self._waiting if each.is_due(now_ms)]
        self._waiting = [each for each in self._waiting if each.command.mode == Mode.STREAMING]
        self._executor.step()

    def leave(self) -> None:
        """End the client's stepping, so that time no longer waits for it."""
        self._simulator.leave(self)

    def _put(self, command: Command) -> None:
        """Add a command. It replaces a command with the same number and identity, unless its status keeps both.

        So a command that ends a stream has the stream's place in the order.
        """
        for index, each in enumerate(self._waiting):
            same = (each.command.code, each.command.identity) == (command.code, command.identity)
            if same and not command.status & KEEP_BOTH:
                self._waiting[index] = WaitingCommand(command)
                return
        self._waiting.append(WaitingCommand(command))

    def _execute(self, waiting: WaitingCommand, now_ms: int) -> Command:
        """Execute a command, and return its answer. A command that ends a stream is returned unchanged."""
        waiting.executed_ms = now_ms
        command = waiting.command
        if command.mode == Mode.DISCONTINUE:
            return Command(command.code, command.mode, command.identity)
        return self._executor.execute(command)
