"""Devices as an app gets them: the driver's own, seen through the layers."""

from __future__ import annotations

from robotcore.hal.devices import (
    Angle,
    Battery,
    Camera,
    Display,
    Encoder,
    Frame,
    Image,
    Range,
    RangeSensor,
    SampleT,
    Sensor,
    Voltage,
)
from robotcore.runtime.layers.base import TickCache


class _Layered(Sensor[SampleT]):
    _inner: Sensor[SampleT]
    _read: TickCache[SampleT]

    @property
    def latest(self) -> SampleT | None:
        """The sample that was read last; looking at it reads nothing."""
        return self._read.latest

    def _newest(self) -> SampleT:
        return self._read()

    def _release(self) -> None:
        self._inner.close()


class LayeredRangeSensor(_Layered[Range], RangeSensor):
    """A range sensor through its layers."""

    def __init__(self, inner: RangeSensor, read: TickCache[Range]) -> None:
        limits = {"min_range": inner.min_range, "max_range": inner.max_range}
        RangeSensor.__init__(self, inner.name, cone=inner.cone, **limits)
        self._inner, self._read = inner, read


class LayeredCamera(_Layered[Frame], Camera):
    """A camera through its layers."""

    def __init__(self, inner: Camera, read: TickCache[Frame]) -> None:
        Camera.__init__(self, inner.name, inner.intrinsics)
        self._inner, self._read = inner, read


class LayeredEncoder(_Layered[Angle], Encoder):
    """An encoder through its layers."""

    def __init__(self, inner: Encoder, read: TickCache[Angle]) -> None:
        Encoder.__init__(self, inner.name)
        self._inner, self._read = inner, read


class LayeredBattery(_Layered[Voltage], Battery):
    """A battery through its layers."""

    def __init__(self, inner: Battery, read: TickCache[Voltage]) -> None:
        Battery.__init__(self, inner.name)
        self._inner, self._read = inner, read


class LayeredDisplay(Display):
    """A display whose newest picture can be looked at."""

    def __init__(self, inner: Display) -> None:
        super().__init__(inner.name)
        self._inner = inner
        self.latest: Image | None = None

    def _show(self, image: Image) -> None:
        self.latest = image
        self._inner.show(image)

    def _release(self) -> None:
        self._inner.close()
