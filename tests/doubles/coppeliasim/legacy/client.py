"""The server's state for one client: the client's commands, and the errors of its calls."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import replace

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.conversation import Conversation
from tests.doubles.coppeliasim.legacy.functions import Functions
from tests.doubles.coppeliasim.legacy.object_commands import (
    CommandHandlers,
    RefusedError,
    create_group_handlers,
    create_object_handlers,
)
from tests.doubles.coppeliasim.legacy.other_commands import (
    ERRORS_KEPT,
    Errors,
    SimulationCommands,
    create_picture_handlers,
    create_simulation_handlers,
    create_value_handlers,
)
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State

IS_RUNNING, IS_PAUSED = 1, 2
"""Bits of the state in a header. The double never sets the bits of real time and of the edit mode."""


class Client:
    """The server's state for one client. Each caller must hold the simulator's lock."""

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._errors: Errors = deque(maxlen=ERRORS_KEPT)
        self._running = SimulationCommands(simulator, self, self._errors)
        functions = Functions(simulator)
        self._handlers: CommandHandlers = {
            **create_object_handlers(functions),
            **create_group_handlers(functions),
            **create_picture_handlers(functions),
            **create_value_handlers(functions),
            **create_simulation_handlers(self._running),
        }
        self._conversation = Conversation()
        self.turn()

    @property
    def is_leaving(self) -> bool:
        """Whether the client has sent its last message."""
        return self._conversation.is_over

    def receive(self, message: bytes) -> bytes:
        """Receive a message, and return the reply, which contains the answers to earlier messages."""
        return self._conversation.receive(message)

    def turn(self) -> None:
        """Execute the received commands, and then the requested time step."""
        self._conversation.execute(self._execute, int(time.monotonic() * 1000), self._state)
        self._running.step()

    def leave(self) -> None:
        """End the client's stepping, so that time no longer waits for it."""
        self._running.leave()

    def _execute(self, command: Command) -> Command:
        sim_ms = round(self._simulator.time * 1000) if self._simulator.state else 0
        try:
            data, status = self._handlers.get(command.code, _unknown)(command), 0
        except RefusedError as refusal:
            data, status = refusal.data, 1
            if refusal.text:
                self._errors.append(refusal.text)
        return replace(command, data=data, status=status, sim_ms=sim_ms, delay_ms=0)

    @property
    def _state(self) -> int:
        state = self._simulator.state
        return IS_RUNNING * (state is not State.STOPPED) | IS_PAUSED * (state is State.PAUSED)


def _unknown(command: Command) -> bytes:
    raise RefusedError(None, command.data)
