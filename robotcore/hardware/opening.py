"""Devices opened one by one: all of them, or none."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack

from robotcore.description import CameraDescription, DisplayDescription, EncoderDescription, RangeSensorDescription
from robotcore.devices import Device
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hardware.driver import Host
from robotcore.hardware.fitting import Fitting

_ORDER = (EncoderDescription, RangeSensorDescription, CameraDescription, DisplayDescription)


def open_devices(fittings: Iterable[Fitting], host: Host, opened: dict[str, Device]) -> None:
    """Open every device into ``opened``, which the host shows to those that come later: motors last.

    Every device is tried; where one fails, all are closed again. Raises the DeviceError, or DeviceGroupError with all
    that failed, in closing too.
    """
    failures: list[Exception] = []
    with ExitStack() as undo:
        for fitting in sorted(fittings, key=_rank):
            try:
                device = fitting.open(host)
            except DeviceError as failure:
                failures.append(failure)
                continue
            undo.callback(_close, device, failures)
            opened[fitting.name] = device
        if not failures:
            undo.pop_all()
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise DeviceGroupError(f"opening {host.robot.name}", failures)


def _close(device: Device, failures: list[Exception]) -> None:
    try:
        device.close()
    except Exception as failure:  # noqa: BLE001  it hides neither why it is closed, nor what else fails
        failures.append(failure)


def _rank(fitting: Fitting) -> int:
    return next((rank for rank, kind in enumerate(_ORDER) if isinstance(fitting.told, kind)), len(_ORDER))
