"""Answers about what is no object: parameters of the simulator, signals, the status bar."""

from __future__ import annotations

import struct

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.functions import Functions
from tests.doubles.coppeliasim.legacy.objects import FLOAT, INT, handle, text, values
from tests.doubles.coppeliasim.legacy.refused import Answers, RefusedError, refusing


def answers_on_values(functions: Functions) -> Answers:
    """Return what can be asked of a simulator besides its objects."""
    parameters, floats, integers = Parameters(functions), Signals(FLOAT), Signals(INT)
    return {
        Code.GET_INTEGER_PARAMETER: parameters.integer,
        Code.GET_FLOATING_PARAMETER: parameters.floating,
        Code.SET_FLOATING_PARAMETER: parameters.set_floating,
        Code.GET_FLOAT_SIGNAL: floats.get,
        Code.SET_FLOAT_SIGNAL: floats.set,
        Code.CLEAR_FLOAT_SIGNAL: floats.clear,
        Code.GET_INTEGER_SIGNAL: integers.get,
        Code.SET_INTEGER_SIGNAL: integers.set,
        Code.CLEAR_INTEGER_SIGNAL: integers.clear,
        Code.ADD_STATUSBAR_MESSAGE: _show,
    }


def _show(command: Command) -> bytes:
    """Show a message to nobody."""
    return b""


class Parameters:
    """The simulator's own numbers; a ping reads one of them, the program's version."""

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def integer(self, command: Command) -> bytes:
        with refusing("simGetIntegerParameter", INT.pack(0)):
            return INT.pack(self._functions.integer(handle(command)))

    def floating(self, command: Command) -> bytes:
        with refusing("simGetFloatingParameter", FLOAT.pack(0.0)):
            return FLOAT.pack(self._functions.floating(handle(command)))

    def set_floating(self, command: Command) -> bytes:
        with refusing("simSetFloatingParameter"):
            self._functions.set_floating(handle(command), *values(FLOAT, command))
        return b""


class Signals:
    """Numbers by name, of one kind. One that is not there is an error without a text."""

    def __init__(self, layout: struct.Struct) -> None:
        self._layout = layout
        self._values: dict[str, float] = {}

    def get(self, command: Command) -> bytes:
        value = self._values.get(text(command.identity))
        if value is None:
            raise RefusedError(None, bytes(self._layout.size))
        return self._layout.pack(value)

    def set(self, command: Command) -> bytes:
        (self._values[text(command.identity)],) = values(self._layout, command)
        return b""

    def clear(self, command: Command) -> bytes:
        """Forget one signal, or all of them where no name is given."""
        if name := text(command.identity):
            self._values.pop(name, None)
        else:
            self._values.clear()
        return b""
