"""Real robots: devices opened one by one, each by the driver that its robot's description names."""

from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware.connections import Connection
from robotcore.hardware.driver import DeviceDriver, Host
from robotcore.hardware.fitting import Fitting
from robotcore.hardware.newest import Newest
from robotcore.hardware.opening import open_devices, open_robot, unopened_cutoffs
from robotcore.hardware.pairing import encoder_of, motor_of
from robotcore.hardware.section import batteries_in, fit
from robotcore.hardware.shared import Shared

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
