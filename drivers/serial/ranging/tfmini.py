"""The driver of Benewake's optical range sensors TFmini, TFmini-S, TFmini Plus and TF-Luna."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from drivers.serial.driver import SerialDriver
from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from drivers.serial.ranging.frames import FULL_BUFFER_BYTES
from drivers.serial.ranging.protocol import Detection, Parser, Reading
from drivers.serial.ranging.sensor import LineRangeSensor
from robotcore.description import RobotDescription
from robotcore.hardware import DeviceContext, Drivers
from robotcore.hardware.polled_samples import RangeSampler, require_timely
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription


class TFminiProtocol(Protocol):
    """Converts the newest frames to samples. The protocol is ready after two frames in a row.

    If several frames arrive at once, only the newest frame becomes a sample, because the times of the others are
    unknown. A sensor that has sent nothing for ``silence_s`` seconds is lost.

    The protocol sends nothing. So it turns no motor if the robot's file has the port of a motor board by mistake.
    """

    def __init__(self, sampler: RangeSampler, baud: int, silence_s: float) -> None:
        self.baud, self.is_ready = baud, False
        self._sampler, self._parser = sampler, Parser()
        self._silence_s, self._received_at = silence_s, -math.inf

    def begin(self, now: float) -> None:
        self.is_ready, self._parser = False, Parser()
        self._sampler.add_unclear()

    def receive(self, data: bytes, now: float) -> None:
        if not (readings := self._parser.feed(data)):
            return
        self.is_ready, self._received_at = True, now
        if len(data) < FULL_BUFFER_BYTES:
            self._add(readings, now)

    def data_to_send(self, now: float) -> bytes:
        if self.is_ready and now - self._received_at > self._silence_s:
            self.begin(now)
        return b""

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        return (_NO_FRAMES if has_received else _SILENT).format(where=f"on {place} at {self.baud} baud")

    def _add(self, readings: Sequence[Reading], now: float) -> None:
        *before, newest = readings
        if any(reading.detection is not Detection.NOTHING for reading in before):
            self._sampler.add_unclear()  # restarts the count of frames without a target
        match newest.detection:
            case Detection.TARGET:
                self._sampler.add_distance(newest.distance, now)
            case Detection.NOTHING:
                self._sampler.add_no_echo(now)
            case Detection.UNCLEAR:
                self._sampler.add_unclear()


_NO_FRAMES = (
    "the data {where} has no frame of a TFmini. Check that this is the sensor's port, set baud to the "
    "sensor's baud rate (115200 from the factory), and set the sensor's output to 9 bytes in cm"
)
_SILENT = (
    "nothing arrives {where}. Check the sensor's 5 V and ground, and that its TX goes to the port's RX. "
    "A sensor that was set to I2C, or to wait for a trigger, sends nothing by itself"
)


MIN_RANGE_M, MAX_RANGE_M = 0.1, 8.0
"""The shortest distance of a TFmini-S or Plus, and the longest distance of a TF-Luna, in metres.

A TF-Luna begins at 0.2 m, and a TFmini at 0.3 m. All models but the TF-Luna reach 12 m. Source: their manuals, chapter
3."""

_FIRST_FRAMES_S = 1.0
"""The longest wait for the first frames of a sensor after power-on, in seconds."""

_SILENCE_S, _SILENT_CYCLES = 0.4, 3
"""A silent sensor is lost after this many seconds or this many cycles, whichever time is longer."""

_EXTRA_CYCLES = 20
"""Opening waits for the first sample for at most ``echo_free_cycles`` plus this many cycles."""


class LightSensor(LineRangeSensor):
    """An optical range sensor, alone on its line."""

    def _start(self) -> None:
        self._opened.callback(self._line.close)
        self._line.open(self.name, _FIRST_FRAMES_S)
        super()._start()


class TFmini(SerialDriver):
    """Opens sensors with factory settings, which periodically send frames of nine bytes in centimetres.

    The time of a sample is the arrival of its frame. The measurement was up to ``cycle_s`` earlier. The distance is
    `inf` for a target beyond ``max_range_m``, and after ``echo_free_cycles`` frames with too little light. A single
    frame with too little light makes no sample. A frame with too much light never makes a sample.
    """

    name = "tfmini"
    summary = "TFmini, TFmini-S, TFmini Plus, TF-Luna: ranging by light up to 8 m, on a serial line"
    described = RangeSensorDescription
    aliases = ("tf-luna", "tfluna", "tfmini-s", "tfmini-plus", "benewake")
    supply = ("5 V", "ground")
    protocol_name = "TFmini"
    default_baud = 115200

    cycle_s: Annotated[float, Field(ge=0.001, le=0.5)] = 0.01
    """The period of the sensor's frames in seconds."""
    echo_free_cycles: Annotated[int, Field(ge=0, le=1000)] = 60
    """After this many frames in a row with too little light, the distance is `inf`. With 0, a frame with too little
    light never makes a sample."""

    def check(self, description: RangeSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_range_m > MAX_RANGE_M:
            raise ValueError(
                f"a TF-Luna measures up to {MAX_RANGE_M:g} m, but max_range_m is {description.max_range_m:g}; lower it"
            )
        if description.min_range_m < MIN_RANGE_M:
            raise ValueError(
                f"a TFmini-S measures from {MIN_RANGE_M:g} m on (TF-Luna: 0.2 m, TFmini: 0.3 m), but min_range_m is "
                f"{description.min_range_m:g}; raise it"
            )
        require_timely(self.echo_free_cycles, self.cycle_s, robot)

    def notes(self, description: RangeSensorDescription) -> Sequence[str]:
        return (_LEVEL, _UNIT)

    def open(self, description: RangeSensorDescription, context: DeviceContext) -> RangeSensor:
        sampler = RangeSampler(description, self.echo_free_cycles)
        protocol = TFminiProtocol(sampler, self.effective_baud, max(_SILENCE_S, _SILENT_CYCLES * self.cycle_s))
        line = Line(self.port, protocol, context.clock)
        sensor = LightSensor(description, sampler, line, self.cycle_s * (self.echo_free_cycles + _EXTRA_CYCLES))
        sensor.open()
        return sensor


_LEVEL = (
    "The sensor runs on 5 V, and its lines have 3.3 V. Connect its TX to the port's RX directly. Its RX may stay open."
)
_UNIT = (
    "The sensor must send centimetres in frames of nine bytes, the factory setting. Frames in millimetres look the "
    "same: hold a flat target 0.5 m in front of the sensor, and check that robotcore reads 0.5 m."
)
