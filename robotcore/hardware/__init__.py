"""The interface of device drivers, and the functions that open a robot's devices with their drivers."""

from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware.binding import batteries_in, bind_devices
from robotcore.hardware.driver import Connection, DeviceBinding, DeviceDriver, Host, Shared
from robotcore.hardware.opening import encoder_of, motor_of, open_devices, open_robot, static_cutoffs
from robotcore.hardware.polled_samples import LatestSample

__all__ = [
    "Connection",
    "DeviceBinding",
    "DeviceDriver",
    "Host",
    "LatestSample",
    "Pad",
    "PadKind",
    "Shared",
    "Wire",
    "Wiring",
    "batteries_in",
    "bind_devices",
    "encoder_of",
    "motor_of",
    "open_devices",
    "open_robot",
    "static_cutoffs",
]
