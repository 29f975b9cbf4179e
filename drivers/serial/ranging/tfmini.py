"""The driver of Benewake's optical range sensors TFmini, TFmini-S, TFmini Plus and TF-Luna."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Annotated

from pydantic import Field

from drivers.serial.driver import PortSettings, SerialDriver
from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from drivers.serial.ranging.protocol import Detection, Parser, Reading
from robotcore.description import RangeSensorDescription, RobotDescription
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware import Connection, Host
from robotcore.hardware.polled_samples import NOTHING_YET, RangeSampler, require_timely

_FULL = 4000
"""If this many unread bytes arrive at once, the kernel's buffer was full and has dropped data. Source: Linux,
N_TTY_BUF_SIZE."""


class TFminiProtocol(Protocol):
    """Makes samples of the newest frames. The protocol is ready after two frames in a row.

    A sensor that has sent nothing for ``silence_s`` seconds is lost. The protocol sends nothing. So it turns no motor
    if the robot's file names the port of a motor board by mistake. If several frames arrive at once, only the newest
    one becomes a sample, because the times of the others are unknown.
    """

    def __init__(self, sampler: RangeSampler, baud: int, silence_s: float) -> None:
        self.baud, self.is_ready = baud, False
        self._sampler, self._parser = sampler, Parser()
        self._silence_s, self._heard_at = silence_s, -math.inf

    def begin(self, now: float) -> None:
        self.is_ready, self._parser = False, Parser()
        self._sampler.add_unclear()

    def receive(self, data: bytes, now: float) -> None:
        if not (readings := self._parser.feed(data)):
            return
        self.is_ready, self._heard_at = True, now
        if len(data) < _FULL:
            self._add(readings, now)

    def data_to_send(self, now: float) -> bytes:
        if self.is_ready and now - self._heard_at > self._silence_s:
            self.begin(now)
        return b""

    def explain_silence(self, place: str, *, has_heard: bool = False) -> str:
        description = _NO_FRAMES if self._parser.skipped else _SILENT
        return description.format(heard=f"on {place} at {self.baud} baud", skipped=self._parser.skipped)

    def _add(self, readings: Sequence[Reading], now: float) -> None:
        """Add the newest frame. If an earlier one had a target, restart the count of frames without a target."""
        *before, newest = readings
        if any(reading.detection is not Detection.NOTHING for reading in before):
            self._sampler.add_unclear()
        match newest.detection:
            case Detection.TARGET:
                self._sampler.add_distance(newest.distance, now)
            case Detection.NOTHING:
                self._sampler.add_no_echo(now)
            case Detection.UNCLEAR:
                self._sampler.add_unclear()


_NO_FRAMES = (
    "{skipped} bytes arrived {heard}, but no frame of a TFmini. Set baud to that of the sensor (115200 from the "
    "factory) and its output to 9 bytes in cm, and check that it is the sensor's port"
)
_SILENT = (
    "nothing arrives {heard}. Check the sensor's 5 V and ground, and that its TX goes to the port's RX. "
    "A sensor that was set to I2C, or to wait for a trigger, sends nothing by itself"
)


NEAREST_M, FARTHEST_M = 0.1, 8.0
"""The shortest distance that one of the four models measures, and the longest one of the TF-Luna, in metres. A TFmini-S
and Plus begin at 0.1 m, a
TF-Luna at 0.2 m, a TFmini at 0.3 m; all but the TF-Luna reach 12 m. Source: their manuals, chapter 3."""

_FIRST_FRAMES_S = 1.0
"""The longest wait for the first frames of a sensor that was just switched on, in seconds."""

_SILENCE_S, _SILENT_CYCLES = 0.4, 3
"""A sensor without data is lost after this many seconds or this many cycles, whichever is longer."""

_MORE_CYCLES = 20
"""Opening waits for the first sample for ``echo_free_cycles`` plus this many cycles."""


class TFminiSettings(PortSettings):
    """The settings of a TFmini."""

    protocol_name = "TFmini"
    default_baud = 115200

    cycle_s: Annotated[float, Field(ge=0.001, le=0.5)] = 0.01
    """The period of the sensor's frames in seconds."""
    echo_free_cycles: Annotated[int, Field(ge=0, le=1000)] = 60
    """After this many frames in a row with too little light, the distance is `inf`. With 0, too little light never
    makes a sample."""


class TFmini(SerialDriver[RangeSensorDescription, TFminiSettings]):
    """Reads a sensor with factory settings: it sends frames of nine bytes, in centimetres, by itself.

    The time of a sample is the arrival of its frame. The measurement is up to ``cycle_s`` older. The distance is `inf`
    for a target beyond ``max_range_m``, and after ``echo_free_cycles`` frames with too little light. A single frame
    with too little light makes no sample, and a frame with too much light never does.
    """

    name = "tfmini"
    summary = "TFmini, TFmini-S, TFmini Plus, TF-Luna: ranging by light up to 8 m, on a serial line"
    described = RangeSensorDescription
    settings = TFminiSettings
    aliases = ("tf-luna", "tfluna", "tfmini-s", "tfmini-plus", "benewake")
    supply = ("5 V", "ground")

    def check(self, description: RangeSensorDescription, settings: TFminiSettings, robot: RobotDescription) -> None:
        if description.max_range_m > FARTHEST_M:
            raise ValueError(
                f"a TF-Luna measures up to {FARTHEST_M:g} m, but max_range_m is {description.max_range_m:g}; lower it"
            )
        if description.min_range_m < NEAREST_M:
            raise ValueError(
                f"a TFmini-S measures from {NEAREST_M:g} m on (TF-Luna: 0.2 m, TFmini: 0.3 m), but min_range_m is "
                f"{description.min_range_m:g}; raise it"
            )
        require_timely(settings.echo_free_cycles, settings.cycle_s, robot)

    def connections(self, settings: TFminiSettings) -> Sequence[Connection]:
        return (
            Connection("port", "serial", settings.port, protocol=f"{settings.protocol_name} at {settings.speed} baud"),
        )

    def notes(self, description: RangeSensorDescription, settings: TFminiSettings) -> Sequence[str]:
        return (_LEVEL, _UNIT)

    def open(self, description: RangeSensorDescription, settings: TFminiSettings, host: Host) -> RangeSensor:
        sampler = RangeSampler(description, settings.echo_free_cycles)
        protocol = TFminiProtocol(sampler, settings.speed, max(_SILENCE_S, _SILENT_CYCLES * settings.cycle_s))
        line = Line(settings.port, protocol, host.clock)
        sensor = LightSensor(description, sampler, line)
        with ExitStack() as undo:
            undo.callback(sensor.close)
            sensor.start(settings.cycle_s * (settings.echo_free_cycles + _MORE_CYCLES))
            undo.pop_all()
        return sensor


class LightSensor(RangeSensor):
    """An optical range sensor that sends distances by itself. Reading raises DeviceLostError while the line is lost."""

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler, line: Line) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sampler, self._line = sampler, line

    def start(self, first_sample_s: float) -> None:
        """Open the line, and wait for the first sample; raises DeviceError if there is none within these seconds."""
        self._line.open(self.name, _FIRST_FRAMES_S)
        self._line.wait_until(lambda: self._sampler.has_result, self.name, first_sample_s, NOTHING_YET)

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._sampler.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest

    def _release(self) -> None:
        self._line.close()


_LEVEL = "It runs on 5 V, and its lines are 3.3 V: its TX goes to the port's RX as it is. Its RX may stay open."
_UNIT = (
    "It must send centimetres in frames of nine bytes, the factory setting. Frames in millimetres look the same: hold "
    "something flat 0.5 m in front of it, and check that it reads 0.5 m."
)
