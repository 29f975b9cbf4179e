"""The drivers of an Arduino's devices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.devices import BoardBattery
from drivers.serial.boards.drivers import BatteryDriver, Board, BoardDriver, BoardTimeout, EncoderDriver, MotorDriver
from drivers.serial.boards.rosarduino.board import FULL_DUTY, ArduinoProtocol
from drivers.serial.boards.rosarduino.devices import (
    ENCODER,
    MUTE_PINGS,
    CountingMotor,
    Pings,
    Ranges,
    counts_per_turn,
    edges_per_turn,
    require_countable,
)
from drivers.serial.boards.rosarduino.protocol import PING_S, RANGE, STOP_CONFIRMED, STOP_NOW, build_ping_request
from drivers.serial.boards.rosarduino.requests import VERSION
from drivers.serial.ranging.sensor import LineRangeSensor
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import DeviceContext, Drivers
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model
from robotcore.hardware.polled_samples import RangeSampler, require_timely
from robotcore.kinds.battery import Battery, BatteryDescription, Voltage
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription

BRIDGE_CYCLE_S = 0.06
"""The period in which robotcore_bridge triggers its ultrasonic module, in seconds."""

ECHO_FREE_S = 0.6
"""The default time without an echo, in seconds, after which nothing is in range."""

BOARD = (
    "The board runs ROSArduinoBridge, or robotcore_bridge, which robotcore firmware flash writes to it. "
    "robotcore_bridge stops sooner, adds checksums, and measures range and battery at any time. The pins are in the "
    'firmware\'s config.h and in the page "The firmware: wheels on an Arduino" of the documentation.'
)
TIMEOUT = (
    "ROSArduinoBridge always stops the motors 2 s after the last command; robotcore_bridge stops them after "
    "board_timeout_s."
)
COUNTING = (
    "The board takes whole counts in 1/30 s. set_velocity returns the velocity of the nearest whole number, and 0 for "
    "less than half a count."
)
EDGES = (
    'With counts_per_turn = {counts_per_turn} and counts = "{counts}", a turn of the wheel has {edges} edges of the '
    "encoder's two channels. If a turn really has a quarter of these edges, the wheel turns four times too fast. Check "
    'the count once as the page "The firmware: wheels on an Arduino" of the documentation describes.'
)
NO_PIN_NOTE = (
    "robotcore_bridge has the module's pins in its config.h. For ROSArduinoBridge, add the pin of the module, such as "
    "pin = 4."
)
PINGING = (
    "ROSArduinoBridge does nothing else while it waits for an echo: 38 ms without an echo, and 1 s without a module at "
    "that pin. In this time it does not control the velocity and takes no stop."
)

COUNT_S = 0.005
"""The period of requesting encoder counts, in seconds; equal to the shortest period of velocity control."""

RANGE_S = 0.03
"""The period of requesting the range from robotcore_bridge, in seconds."""

FLASH = "flash robotcore_bridge: robotcore firmware flash"

NOT_WIRED = (
    "the board's firmware was built without a battery; set BATTERY_PIN in config.h to the pin of its divider, and "
    "flash it again"
)


class ArduinoDriver(BoardDriver):
    """The base class of the drivers of an Arduino's devices."""

    aliases: ClassVar[tuple[str, ...]] = ("arduino", "uno", "nano", "robotcore-bridge", "rosarduinobridge")
    protocol_name = "ROSArduinoBridge"
    default_baud = 57600
    protocol = ArduinoProtocol
    answer_s = 4.0  # opening the port resets an Arduino, and its boot loader waits up to two seconds for a new sketch
    stop, standing = STOP_NOW, STOP_CONFIRMED

    def notes(self, description: Any) -> Sequence[str]:
        return (BOARD,)

    def open_board(self, device: str, context: DeviceContext) -> Board:
        board = super().open_board(device, context)
        if (version := board.protocol.firmware.version) != VERSION:
            problem = f"its firmware has version {version} of the protocol, and this robotcore supports {VERSION}"
            remedy = "flash the firmware of this robotcore: robotcore firmware flash"
            text = f"the board on {self.port} is not supported: {problem}; {remedy}"
            raise DeviceError(device, text, kind="firmware-version", place=self.port)
        return board

    def open_board_with_wheels(self, device: str, context: DeviceContext) -> Board:
        """Return the board of a motor or an encoder; raises DeviceError if its firmware was built without wheels."""
        board = self.open_board(device, context)
        if not board.protocol.firmware.has_wheels:
            text = f"the ROSArduinoBridge on {self.port} was built without wheels. Define USE_BASE and flash it again"
            raise DeviceError(device, f"{text}, or {FLASH}", kind="board-without-wheels", place=self.port)
        return board

    def require_robotcore_bridge(self, board: Board, device: str, lacks: str, instead: str = "") -> None:
        """Raise DeviceError if the board does not run robotcore_bridge.

        lacks: the missing ability of ROSArduinoBridge, for the message, such as ``measures no battery``.
        instead: a remedy other than flashing robotcore_bridge; empty if there is none.
        """
        if not board.protocol.firmware.is_robotcore_bridge:
            remedy = f"{instead}, or {FLASH}" if instead else FLASH
            text = f"the board on {self.port} runs ROSArduinoBridge, which {lacks}. {remedy[0].upper()}{remedy[1:]}"
            raise DeviceError(device, text, kind="firmware-lacks", place=self.port, lacks=lacks)


class ArduinoMotor(ArduinoDriver, MotorDriver):
    """Opens motors on an Arduino. A motor with a model gets duties.

    Without a model, the board controls the velocity by the wheel's encoder, which is on the same board.

    The driver sets the time-out of robotcore_bridge. The time-out of ROSArduinoBridge is always 2 s.
    """

    name = "ros-arduino-motor"
    summary = "a motor on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    reports_direction = True
    duty_steps = FULL_DUTY

    board_timeout_s: BoardTimeout = 0.5
    model: Model | None = None
    """The velocity of the wheel at each duty. With a model, the driver sends duties."""
    control: Control | None = None
    """The settings of velocity control by this process and the wheel's encoder. They need ``model``."""

    def notes(self, description: MotorDescription) -> Sequence[str]:
        return (BOARD, TIMEOUT) if self.model else (BOARD, TIMEOUT, COUNTING)

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if self.model:
            require_drivable(description, self.model, self.control, robot)
            return
        if self.control:
            raise ValueError("control needs the motor's model, which is missing; add model, or leave control out")
        require_countable(description, counts_per_turn(description.name, self.port, robot))

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        board = self.open_board_with_wheels(description.name, context)
        self._set_duty_mode(board, description.name)
        board.protocol.limit(self.board_timeout_s)
        if self.model:
            output = self.open_output(description.name, context)
            return open_motor(description, self.model, self.control, lambda: output, context)
        counts = counts_per_turn(description.name, self.port, context.robot)
        unit = counts / math.tau * board.protocol.firmware.control_period_s
        return CountingMotor(description, self.open_output(description.name, context, unit), self.trim * unit)

    def _set_duty_mode(self, board: Board, motor: str) -> None:
        is_duty_mode = self.model is not None
        if is_duty_mode and not board.protocol.firmware.takes_duties:
            self.require_robotcore_bridge(board, motor, "takes no duties", "remove model from both motors")
        if board.protocol.is_duty_mode not in (None, is_duty_mode):
            text = f"one motor on {self.port} has a model, and the other has none. Give both motors a model, or neither"
            raise DeviceError(motor, text, kind="motors-differ", place=self.port)
        board.protocol.is_duty_mode = is_duty_mode


class ArduinoEncoder(ArduinoDriver, EncoderDriver):
    """Opens encoders on an Arduino. One reply of the board has the counts of both encoders."""

    name = ENCODER
    summary = "a wheel's encoder on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"

    counts: Literal["cycles", "edges"] = "cycles"
    """The unit of ``counts_per_turn`` in the robot's description.

    "cycles" are the cycles of one channel: the PPR of a data sheet, or the slots of a disc. "edges" are the edges of
    both channels, four in each cycle, often called CPR. A turn is a turn of the wheel, not of the motor
    in front of a gear."""

    def notes(self, description: EncoderDescription) -> Sequence[str]:
        edges = edges_per_turn(description, self.counts)
        return BOARD, EDGES.format(edges=edges, counts_per_turn=description.counts_per_turn, counts=self.counts)

    def open(self, description: EncoderDescription, context: DeviceContext) -> Encoder:
        self.open_board_with_wheels(description.name, context).protocol.count_every(COUNT_S)
        return super().open(description, context)

    def rad_per_unit(self, description: EncoderDescription, robot: RobotDescription) -> float:
        return math.tau / edges_per_turn(description, self.counts)


class ArduinoSonar(ArduinoDriver):
    """Opens ultrasonic modules on an Arduino.

    robotcore_bridge measures periodically. ROSArduinoBridge measures on request, and processes no other request until
    the measurement ends.
    """

    name = "ros-arduino-sonar"
    summary = "an ultrasonic module on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    described = RangeSensorDescription
    part_key = "pin"
    aliases: ClassVar[tuple[str, ...]] = ("arduino", "sonar", "ultrasonic", "hc-sr04")

    pin: Annotated[int, Field(ge=2, le=69)] | None = None
    """The module's pin on the Arduino. Only ROSArduinoBridge needs it; robotcore_bridge has it in config.h."""
    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.1
    """The period of measuring with ROSArduinoBridge, in seconds. The period of robotcore_bridge is always 0.06 s."""
    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] | None = None
    """After this many cycles in a row without an echo, the distance is `inf`. None means the cycles in 0.6 s.

    With 0, only an echo from beyond the maximum range makes the distance `inf`."""

    @property
    def cycle(self) -> float:
        """The period of measuring in seconds: that of robotcore_bridge if no pin is set, else ``cycle_s``."""
        return BRIDGE_CYCLE_S if self.pin is None else self.cycle_s

    @property
    def cycles(self) -> int:
        """The number of cycles in a row without an echo after which the distance is `inf`."""
        return max(1, round(ECHO_FREE_S / self.cycle)) if self.echo_free_cycles is None else self.echo_free_cycles

    @property
    def part(self) -> str:
        return "sonar" if self.pin is None else f"sonar on pin {self.pin}"

    def notes(self, description: RangeSensorDescription) -> Sequence[str]:
        return BOARD, NO_PIN_NOTE if self.pin is None else PINGING

    def check(self, description: RangeSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        require_timely(self.cycles, self.cycle, robot)

    def open(self, description: RangeSensorDescription, context: DeviceContext) -> RangeSensor:
        board = self.open_board(description.name, context)
        sampler = RangeSampler(description, self.cycles)
        if self.pin is None:
            instead = f"set the module's pin in the robot's file, such as pin = 4 in [serial.{description.name}]"
            self.require_robotcore_bridge(board, description.name, "needs the module's pin in each request", instead)
        if board.protocol.firmware.is_robotcore_bridge:
            board.protocol.poll(RANGE, RANGE_S, Ranges(description.name, sampler).take)
        else:
            assert self.pin
            board.protocol.poll(build_ping_request(self.pin), self.cycle_s, Pings(description, sampler).take)
        first_s = self.first_s + (PING_S * MUTE_PINGS if self.pin else 0)
        sonar = LineRangeSensor(description, sampler, board.line, first_s)
        sonar.open()
        return sonar


class ArduinoBattery(ArduinoDriver, BatteryDriver):
    """Opens the battery that robotcore_bridge measures with a voltage divider. ROSArduinoBridge cannot measure one."""

    name = "ros-arduino-battery"
    summary = "the battery of an Arduino with robotcore_bridge, on a serial line"

    def open(self, description: BatteryDescription, context: DeviceContext) -> Battery:
        board = self.open_board(description.name, context)
        self.require_robotcore_bridge(board, description.name, "measures no battery")
        board.protocol.measure_voltage()

        def read_voltage() -> Voltage | None:
            if not board.protocol.has_battery:
                raise DeviceError(description.name, NOT_WIRED, kind="battery-not-wired")
            voltage: Voltage | None = board.protocol.voltage
            return voltage

        return BoardBattery(description.name, board.line, read_voltage, self.first_s)
