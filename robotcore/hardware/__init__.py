"""Real robots: devices opened one by one, each by the driver that its robot's description names."""

from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware.binding import batteries_in, fit
from robotcore.hardware.driver import Connection, DeviceDriver, Fitting, Host, Shared
from robotcore.hardware.opening import encoder_of, motor_of, open_devices, open_robot, unopened_cutoffs
from robotcore.hardware.polled import Newest

__all__ = [
    "Connection",
    "DeviceDriver",
    "Fitting",
    "Host",
    "Newest",
    "Pad",
    "PadKind",
    "Shared",
    "Wire",
    "Wiring",
    "batteries_in",
    "encoder_of",
    "fit",
    "motor_of",
    "open_devices",
    "open_robot",
    "unopened_cutoffs",
]
