"""Real input devices of a simulated robot, such as the gamepad of the person who drives it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import DescriptionError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device, Sensor
from robotcore.hal.kind import load_kind
from robotcore.hardware.binding import bind_devices
from robotcore.hardware.driver import Connection, DeviceBinding, DeviceContext
from robotcore.text import pluralize

INPUT = "input"
"""The bus of the devices that a simulator may open: those by which a person gives input to this computer."""


class SimulatorBackend(Backend):
    """The base class of simulators whose robots may have real input devices.

    The simulator's section in the robot's file names the drivers of these devices. All other devices are simulated.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.backend import load_backend
    >>> kinematic = load_backend("kinematic")
    >>> isinstance(kinematic, SimulatorBackend), kinematic.check(load_robot("rover"))  # it has no real device
    (True, '')
    """

    def check(self, robot: RobotDescription) -> str:
        bindings = self._bind(robot, {device.name for device in robot.devices})
        return pluralize(len(bindings), "real device") if bindings else ""

    def open_each(self, setup: Setup, clock: Clock, simulate: Callable[[Any], Device]) -> list[Device]:
        """Open all chosen devices, and return them.

        simulate: the function that simulates a device. Its argument is the device's description.

        Raises DescriptionError for mistakes in the section, and DeviceGroupError with the failures of all devices.
        """
        real = {binding.name: binding for binding in self._bind(setup.robot, setup.devices)}
        context = DeviceContext(setup.robot, clock)

        def open_one(description: Any) -> Device:
            binding = real.get(description.name)
            return binding.open(context) if binding else simulate(description)

        return setup.open_each(open_one)

    def _bind(self, robot: RobotDescription, names: Iterable[str]) -> tuple[DeviceBinding, ...]:
        if (tables := robot.backends.get(self.name)) is None:
            return ()
        bindings = bind_devices(robot, self.name, tables.keys() & set(names), self._refuse_wires)
        for binding in bindings:
            if not issubclass(load_kind(binding.description.kind).device, Sensor):
                key, problem = f"{self.name}.{binding.name}", "a simulator moves no real device"
                raise DescriptionError(robot.source, key, problem, "Remove the table", kind="real-actuator")
        return bindings

    def _refuse_wires(self, connection: Connection) -> tuple[()]:
        if connection.bus != INPUT:
            raise ValueError(
                f"the simulator {self.name!r} opens no device on {connection.bus}; remove the table, and the simulator "
                "simulates the device"
            )
        return ()
