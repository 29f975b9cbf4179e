"""The handlers of commands about vision sensors, parameters, signals and the simulation."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Hashable

import numpy as np
from numpy.typing import NDArray

from tests.doubles.coppeliasim.legacy.codec import Code, Command
from tests.doubles.coppeliasim.legacy.functions import Functions
from tests.doubles.coppeliasim.legacy.object_commands import (
    FLOAT,
    INT,
    CommandHandlers,
    RefusedError,
    convert_refusals,
    handle,
    text,
    values,
)
from tests.doubles.coppeliasim.scene.simulator import Simulator

RESOLUTION = struct.Struct("<2i")


def create_picture_handlers(functions: Functions) -> CommandHandlers:
    """Return the handlers of commands about vision sensors."""
    pictures = PictureCommands(functions)
    return {
        Code.GET_VISION_SENSOR_IMAGE_BW: pictures.grey,
        Code.GET_VISION_SENSOR_IMAGE_RGB: pictures.colour,
        Code.SET_VISION_SENSOR_IMAGE_BW: pictures.set_grey,
        Code.SET_VISION_SENSOR_IMAGE_RGB: pictures.set_colour,
        Code.READ_VISION_SENSOR: pictures.read,
    }


class PictureCommands:
    """The handlers of commands about a vision sensor.

    The data has width, height and the pixels, the lowest row first.
    """

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def colour(self, command: Command) -> bytes:
        return _encode_image(self._image(command))

    def grey(self, command: Command) -> bytes:
        """Return the mean of the three colours, rounded down, as the server does."""
        image = self._image(command)
        return _encode_image((image.sum(axis=2, dtype=np.uint16) // 3).astype(np.uint8))

    def set_colour(self, command: Command) -> bytes:
        return self._set(command, channels=3)

    def set_grey(self, command: Command) -> bytes:
        return self._set(command, channels=1)

    def read(self, command: Command) -> bytes:
        """Refuse without a text, as the real server does while it is stopped.

        No recording has an answer during a run.
        """
        self._image(command)
        raise RefusedError(None, INT.pack(0))

    def _image(self, command: Command) -> NDArray[np.uint8]:
        with convert_refusals("simGetVisionSensorResolution"):
            return self._functions.picture(handle(command))

    def _set(self, command: Command, channels: int) -> bytes:
        with convert_refusals("simGetVisionSensorResolution"):
            rows, columns = self._functions.resolution(handle(command))
        if len(command.data) != rows * columns * channels:
            raise RefusedError
        pixels = np.frombuffer(command.data, np.uint8).reshape(rows, columns, channels)
        with convert_refusals("simSetVisionSensorCharImage"):
            self._functions.show(handle(command), np.broadcast_to(pixels, (rows, columns, 3)))
        return b""


def _encode_image(image: NDArray[np.uint8]) -> bytes:
    return RESOLUTION.pack(image.shape[1], image.shape[0]) + image.tobytes()


def create_value_handlers(functions: Functions) -> CommandHandlers:
    """Return the handlers of commands about parameters, signals and the status bar."""
    parameters, floats, integers = ParameterCommands(functions), SignalCommands(FLOAT), SignalCommands(INT)
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
    return b""


class ParameterCommands:
    """The handlers of commands about parameters of the simulator. A ping reads the program version."""

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def integer(self, command: Command) -> bytes:
        with convert_refusals("simGetIntegerParameter", INT.pack(0)):
            return INT.pack(self._functions.integer(handle(command)))

    def floating(self, command: Command) -> bytes:
        with convert_refusals("simGetFloatingParameter", FLOAT.pack(0.0)):
            return FLOAT.pack(self._functions.floating(handle(command)))

    def set_floating(self, command: Command) -> bytes:
        with convert_refusals("simSetFloatingParameter"):
            self._functions.set_floating(handle(command), *values(FLOAT, command))
        return b""


class SignalCommands:
    """The handlers of commands about signals of one type. A missing signal is an error without a text."""

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
        """Remove one signal, or all signals if the name is empty."""
        if name := text(command.identity):
            self._values.pop(name, None)
        else:
            self._values.clear()
        return b""


Errors = deque[str]
ERRORS_KEPT = 50


def create_simulation_handlers(running: SimulationCommands) -> CommandHandlers:
    """Return the handlers of commands about the simulation."""
    return {
        Code.START_PAUSE_STOP_SIMULATION: running.start_pause_stop,
        Code.SYNCHRONOUS_ENABLE: running.hold_time,
        Code.SYNCHRONOUS_DISABLE: running.let_time_pass,
        Code.SYNCHRONOUS_NEXT: running.trigger,
        Code.GET_LAST_ERRORS: running.last_errors,
    }


class SimulationCommands:
    """The commands about the simulation.

    client: the client that steps.
    errors: the errors of its calls.
    """

    def __init__(self, simulator: Simulator, client: Hashable, errors: Errors) -> None:
        self._simulator, self._client, self._errors = simulator, client, errors
        self._is_triggered = False

    def start_pause_stop(self, command: Command) -> bytes:
        number = handle(command)
        if not 0 <= number <= 2:
            raise RefusedError
        (self._simulator.start, self._simulator.pause, self._simulator.stop)[number]()
        return b""

    def hold_time(self, command: Command) -> bytes:
        """Make time wait for triggers, until the client ends stepping or the simulation stops."""
        if not self._steps:
            self._simulator.stepping.raise_level(self._client)
        return b""

    def let_time_pass(self, command: Command) -> bytes:
        self.leave()
        return b""

    def leave(self) -> None:
        """End the client's stepping, so that time no longer waits for it."""
        self._simulator.stepping.remove(self._client)
        self._simulator.changed.notify_all()

    def trigger(self, command: Command) -> bytes:
        """Request a time step, which follows the other commands of the message.

        Returns an error if the client does not step, or if the simulation is stopped.
        """
        if not self._steps or not self._simulator.state.is_advancing:
            raise RefusedError
        self._is_triggered = True
        return b""

    def step(self) -> None:
        """Simulate the requested time step."""
        if self._is_triggered:
            self._is_triggered = False
            self._simulator.step(self._client)

    def last_errors(self, command: Command) -> bytes:
        """Return the number of errors and their texts, and clear them."""
        texts = b"".join(error.encode() + b"\0" for error in self._errors)
        answer = INT.pack(len(self._errors)) + texts
        self._errors.clear()
        return answer

    @property
    def _steps(self) -> bool:
        return bool(self._simulator.stepping.level(self._client))
