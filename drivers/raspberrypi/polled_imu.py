"""The base classes of the drivers of IMUs on an I2C bus, which read their chip beside the app."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from drivers.raspberrypi.i2c import ChipDriver
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.device_test import REVERSED
from robotcore.hardware.polled_samples import NewestSample
from robotcore.kinds.imu import Imu, ImuDescription, ImuSample

Axis = Literal["x", "y", "-x", "-y"]

TURNS: dict[Axis, tuple[int, int]] = {"x": (1, 0), "y": (0, 1), "-x": (-1, 0), "-y": (0, -1)}
"""For each axis of the chip that points forward, the components of the forward direction along the chip's x and y."""


class ImuDriver(ChipDriver):
    """The base class of the drivers of IMUs, with the settings of the mounting."""

    described = ImuDescription
    extra = "imu"
    remedy = "On the Pi: pip install 'robotcore[imu]'"

    cycle_s: Annotated[float, Field(ge=0.005, le=0.1)] = 0.01
    """The time between two reads of the chip, in seconds."""

    forward_axis: Axis = "x"
    """The axis printed on the chip's board that points forward."""

    is_upside_down: bool = False
    """Whether the chip's z axis points down."""

    def notes(self, description: ImuDescription) -> Sequence[str]:
        return (f"Mount the chip level, with its {self.forward_axis} axis forward.",)

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"is_upside_down": not self.is_upside_down} if mistake == REVERSED else None

    @abstractmethod
    def begin(self, bus: Any) -> Any:
        """Set the chip up, and return the library's object for it."""


class Motion(NamedTuple):
    """One measurement in the robot's frame, in rad/s and m/s²."""

    yaw_rate: float
    forward: float
    left: float


class PolledImu(Imu):
    """An IMU that reads its chip once in each cycle, and sets the chip up again after a failure."""

    transient: ClassVar[frozenset[str]] = frozenset()
    """The kinds of the errors after which the chip is not set up again."""

    def __init__(self, name: str, settings: ImuDriver, clock: Clock) -> None:
        super().__init__(name)
        self._driver, self._clock = settings, clock
        self._library: Any = None
        self._bus = ExitStack()
        self._opened = ExitStack()
        self._sequence = 0
        self._latest: NewestSample[ImuSample] = NewestSample(name, DeviceError(name, "has no sample yet"))

    def open(self) -> None:
        """Prepare the chip, and take the first sample; closes the IMU and raises DeviceError if it fails."""
        self._opened.callback(self._disconnect)
        try:
            self._prepare()
            self._poll()
            self._newest()
            self._opened.callback(self._clock.call_every(self._driver.cycle_s, self._poll, self.name).stop)
        except BaseException:
            self.close()
            raise

    @abstractmethod
    def _prepare(self) -> None:
        """Prepare the measurement at the opening. Raises DeviceError if the robot moves."""

    @abstractmethod
    def _measure(self, now: float) -> tuple[Motion, float]:
        """Read the chip, and return the motion without gravity, and the heading in radians.

        now: the time in seconds.

        Raises DeviceError if the chip fails.
        """

    def _poll(self) -> None:
        now = self._clock.now()
        try:
            motion, heading = self._measure(now)
        except DeviceError as error:
            if error.kind not in self.transient:
                self._disconnect()
            self._latest.fail(error)
        else:
            self._latest.put(ImuSample(*motion, heading, now, self._sequence))
            self._sequence += 1

    def _connect(self) -> Any:
        """Return the library's object of the chip, which is set up first if it is not."""
        if self._library is None:
            with self._driver.translate_errors(self.name), ExitStack() as undo:
                self._library = self._driver.begin(self._driver.open_bus(undo))
                self._bus = undo.pop_all()
        return self._library

    def _disconnect(self) -> None:
        self._library = None
        self._bus.close()

    def _newest(self) -> ImuSample:
        return self._latest.get()

    def _release(self) -> None:
        self._opened.close()
