"""The interface of device drivers, and the functions that open a robot's devices with their drivers."""

from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware.backend import HardwareBackend
from robotcore.hardware.binding import bind_devices, list_drivers
from robotcore.hardware.driver import Connection, DeviceBinding, DeviceContext, DeviceDriver, Drivers, Shared
from robotcore.hardware.opening import encoder_of, motor_of, open_devices, open_robot
from robotcore.hardware.polled_samples import NewestSample, PolledRangeSensor, RangeSampler
from robotcore.hardware.simulator_backend import SimulatorBackend

__all__ = [
    "Connection",
    "DeviceBinding",
    "DeviceContext",
    "DeviceDriver",
    "Drivers",
    "HardwareBackend",
    "NewestSample",
    "Pad",
    "PadKind",
    "PolledRangeSensor",
    "RangeSampler",
    "Shared",
    "SimulatorBackend",
    "Wire",
    "Wiring",
    "bind_devices",
    "encoder_of",
    "list_drivers",
    "motor_of",
    "open_devices",
    "open_robot",
]
