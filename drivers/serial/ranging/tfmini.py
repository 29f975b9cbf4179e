"""The driver of TFmini, TFmini-S, TFmini Plus and TF-Luna, Benewake's light-ranging sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Annotated

from pydantic import Field

from drivers.serial.driver import PortSettings, SerialDriver
from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from drivers.serial.ranging.protocol import Parser, Reading, Seen
from robotcore.description import RangeSensorDescription, RobotDescription
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware import Connection, Host
from robotcore.hardware.polled import NOTHING_YET, RangeSampler, require_timely

_FULL = 4000
"""Of what nobody reads the kernel keeps little more; what comes later is dropped. Source: Linux, N_TTY_BUF_SIZE."""


class TFminiProtocol(Protocol):
    """Tells the findings what the newest frame says; it is ready once two frames have come in a row.

    One that has said nothing for ``silence_s`` is lost, as a board is: its last sample is read no more.

    It sends nothing, so that a port that is another board's turns nothing. Of frames that come at once only the newest
    has its distance told, for when the others came nobody knows.
    """

    def __init__(self, findings: RangeSampler, baud: int, silence_s: float) -> None:
        self.baud, self.is_ready = baud, False
        self._findings, self._parser = findings, Parser()
        self._silence_s, self._heard_at = silence_s, -math.inf

    def begin(self, now: float) -> None:
        self.is_ready, self._parser = False, Parser()
        self._findings.add_unclear()

    def receive(self, data: bytes, now: float) -> None:
        if not (readings := self._parser.feed(data)):
            return
        self.is_ready, self._heard_at = True, now
        if len(data) < _FULL:
            self._judge(readings, now)

    def due(self, now: float) -> bytes:
        if self.is_ready and now - self._heard_at > self._silence_s:
            self.begin(now)
        return b""

    def unanswered(self, place: str, *, has_heard: bool = False) -> str:
        description = _NO_FRAMES if self._parser.skipped else _SILENT
        return description.format(heard=f"on {place} at {self.baud} baud", skipped=self._parser.skipped)

    def _judge(self, readings: Sequence[Reading], now: float) -> None:
        """Tell the newest; one before it that has seen something ends a row in which nothing was found."""
        *before, newest = readings
        if any(reading.seen is not Seen.NOTHING for reading in before):
            self._findings.add_unclear()
        match newest.seen:
            case Seen.TARGET:
                self._findings.add_distance(newest.distance, now)
            case Seen.NOTHING:
                self._findings.add_no_echo(now)
            case Seen.UNCLEAR:
                self._findings.add_unclear()


_NO_FRAMES = (
    "{skipped} bytes came {heard}, and no frame of a TFmini. Set baud to what the sensor was set to (115200 from the "
    "factory) and its output to 9 bytes in cm, and see that it is the sensor's port"
)
_SILENT = (
    "nothing comes {heard}; look at its 5 V and its ground, and whether its TX goes to the port's RX. "
    "One that was set to I2C, or to wait for a trigger, says nothing by itself"
)


NEAREST_M, FARTHEST_M = 0.1, 8.0
"""What none of them sees nearer, or the TF-Luna no farther: a TFmini-S and Plus begin at 0.1 m, a TF-Luna at 0.2 m, a
TFmini at 0.3 m, and all but the TF-Luna end at 12 m. Source: their manuals, chapter 3."""

_FIRST_FRAMES_S = 1.0
"""A sensor that has just been given power talks after less."""

_SILENCE_S, _SILENT_CYCLES = 0.4, 3
"""A sensor that has said nothing for longer, of both, is lost."""

_MORE_CYCLES = 20
"""What the first sample may take beside a row of frames in which nothing was found."""


class TFminiSettings(PortSettings):
    """Its port, how often it tells a distance, as it was set up, and how it is judged.

    So many ``echo_free_cycles`` in a row, in which too little light came back, vouch for nothing in range; 0: none do.
    """

    speaks = "TFmini"
    usual_baud = 115200

    cycle_s: Annotated[float, Field(ge=0.001, le=0.5)] = 0.01
    echo_free_cycles: Annotated[int, Field(ge=0, le=1000)] = 60


class TFmini(SerialDriver[RangeSensorDescription, TFminiSettings]):
    """Listens to a sensor as it comes from the factory: frames of nine bytes, in centimetres, by themselves.

    A sample's time is when its frame arrived; the light is up to ``cycle_s`` older. `inf` is a target beyond
    ``max_range_m``, or a row of frames in which too little light came back; a single one of these, as from something
    dark, is no new sample, and neither is too much light.
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
                f"a TF-Luna sees as far as {FARTHEST_M:g} m, and max_range_m is {description.max_range_m:g}; lower it"
            )
        if description.min_range_m < NEAREST_M:
            raise ValueError(
                f"what is nearer than {NEAREST_M:g} m has no distance for a TFmini-S (TF-Luna: 0.2 m, TFmini: 0.3 m), "
                f"and min_range_m is {description.min_range_m:g}; raise it"
            )
        require_timely(settings.echo_free_cycles, settings.cycle_s, robot)

    def connections(self, settings: TFminiSettings) -> Sequence[Connection]:
        return (Connection("port", "serial", settings.port, protocol=f"{settings.speaks} at {settings.speed} baud"),)

    def notes(self, description: RangeSensorDescription, settings: TFminiSettings) -> Sequence[str]:
        return (_LEVEL, _UNIT)

    def open(self, description: RangeSensorDescription, settings: TFminiSettings, host: Host) -> RangeSensor:
        findings = RangeSampler(description, settings.echo_free_cycles)
        protocol = TFminiProtocol(findings, settings.speed, max(_SILENCE_S, _SILENT_CYCLES * settings.cycle_s))
        line = Line(settings.port, protocol, host.clock)
        sensor = LightSensor(description, findings, line)
        with ExitStack() as undo:
            undo.callback(sensor.close)
            sensor.start(settings.cycle_s * (settings.echo_free_cycles + _MORE_CYCLES))
            undo.pop_all()
        return sensor


class LightSensor(RangeSensor):
    """A sensor that tells its distances by itself; while its line is lost it is read no more."""

    def __init__(self, description: RangeSensorDescription, findings: RangeSampler, line: Line) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._findings, self._line = findings, line

    def start(self, first_sample_s: float) -> None:
        """Open the line and see something within so many seconds; raises DeviceError."""
        self._line.open(self.name, _FIRST_FRAMES_S)
        self._line.wait_until(lambda: self._findings.has_result, self.name, first_sample_s, NOTHING_YET)

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._findings.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest

    def _release(self) -> None:
        self._line.close()


_LEVEL = "It runs on 5 V, and its lines are 3.3 V: its TX goes to the port's RX as it is. Its RX may stay open."
_UNIT = (
    "It has to tell centimetres in frames of nine bytes, as it does from the factory: millimetres look the same. Hold "
    "something flat 0.5 m in front of it, and see that it reads 0.5 m."
)
