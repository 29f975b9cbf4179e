"""A robot for unit tests of apps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.geometry import Wheels
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot, Role
from robotcore.hal.value_log import Logged
from robotcore.optics import Image
from robotcore.runtime.behaviour import Behaviour, Status, require_declarations
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import choose_devices, require_turn_on_spot
from robotcore.runtime.trace import TickRecord
from robotcore.testing.mock.backend import MockBackend
from robotcore.testing.mock.devices import Command, MockActuator, MockDisplay, Script


class MockRobot:
    """A robot that runs an app tick by tick on scripted readings, with the layers and the loop of a real run.

    As in a real run, only the devices of the app's ``needs`` and ``wants`` are opened.

    robot: the description of the robot, or its name or file.
    range: the script of the first range sensor, in metres.
    camera: the script of the first camera: BGR pictures, ``uint8`` of shape (height, width, 3).
    readings: the scripts of other sensors, by name. A reading is the value of a sample, such as True for a bumper, or a
        mapping of field to value for a sample with several values.
    rate_hz: the number of ticks per second.
    faults: injected faults, written as for the option ``--fault``, such as ``camera drop=0.2``.
    seed: the seed of the faults' random numbers.

    Raises UsageError if a constant or a list has a reading that the sensor cannot have.

    >>> from robotcore import Behaviour, Role, Status
    >>> class Reflex(Behaviour):
    ...     needs = frozenset({Role.DRIVE, Role.RANGE})
    ...
    ...     def step(self, robot):
    ...         is_near = robot.range.read().distance < 0.4
    ...         robot.drive.set_velocity(0.0 if is_near else 0.2, 1.0 if is_near else 0.0)
    ...         return Status.RUNNING
    >>> robot = MockRobot(range=[1.0, 0.2])  # one reading a tick, in metres; the last one repeats
    >>> robot.run(Reflex(), ticks=2)
    <Status.RUNNING: 'running'>
    >>> ahead, turning = robot.wheels
    >>> ahead.left == ahead.right, turning.left < turning.right
    (True, True)
    >>> [record.time for record in robot.ticks]
    [0.0, 0.05]
    >>> robot
    MockRobot('rover', ticks=2)
    """

    def __init__(
        self,
        robot: str | RobotDescription = "rover",
        *,
        range: Script | None = None,  # noqa: A002  the role's name
        camera: Script | None = None,
        readings: Mapping[str, Script] | None = None,
        rate_hz: float = 20.0,
        faults: Sequence[str] = (),
        seed: int = 0,
    ) -> None:
        self.description = load_robot(robot) if isinstance(robot, str) else robot
        self.rate_hz = rate_hz
        if isinstance(faults, str):
            raise UsageError(
                f"faults is {faults!r}; it must be a list of specifications, such as [{faults!r}]",
                kind="wrong-type",
                field="faults",
            )
        self._faults, self._seed = tuple(faults), seed
        self.ticks: list[TickRecord] = []
        """The record of each tick so far."""
        self.wheels: list[Wheels] = []
        """The wheel velocities in rad/s at the end of each tick."""
        roles = {Role.RANGE: range, Role.CAMERA: camera}
        scripts = {self._find_first(role): script for role, script in roles.items() if script is not None}
        self._backend = MockBackend({**(readings or {}), **scripts})
        self._backend.check_scripts(self.description)
        self._app: Behaviour | None = None

    def run(self, app: Behaviour, ticks: int = 1) -> Status:
        """Run the app for ``ticks`` ticks, or until it ends, and return its last status.

        A further call continues the run. Raises the errors that end a real run: SafetyStop, DeviceError and
        BehaviourError. Raises UnmetNeedError if the robot has not all devices of the app's ``needs``, and UsageError if
        a needed battery has no script, or if the app turns on the spot and the robot cannot.
        """
        if isinstance(app, type):
            raise UsageError(f"run needs an instance of the app. Write run({app.__name__}())", kind="not-an-instance")
        require_declarations(app)
        if app.turns_on_spot:
            require_turn_on_spot(self.description)
        if ticks < 1:
            raise UsageError(f"ticks is {ticks}; it must be at least 1", kind="no-ticks", ticks=ticks)
        self._app = self._app or app
        loop = Loop(self._assembled, app, self.rate_hz, math.inf, [self._record_tick])
        for _ in range(ticks):
            if (status := loop.tick()) is not Status.RUNNING:
                loop.end()
                return status
            self.advance()
        return Status.RUNNING

    def advance(self, ticks: int = 1) -> None:
        """Advance the clock by ``ticks`` ticks without calling the app, as if the app hung."""
        clock = self._assembled.clock
        for _ in range(ticks):
            clock.sleep_until(clock.now() + 1 / self.rate_hz)

    def __repr__(self) -> str:
        return f"MockRobot({self.description.name!r}, ticks={len(self.ticks)})"

    @property
    def layered(self) -> Robot:
        """The robot with the layers of a real run, as the app receives it. Before `run`, all its devices are open."""
        return self._assembled.robot

    @property
    def commands(self) -> dict[str, list[Command]]:
        """The commands that each actuator received after all safety layers, by the actuator's name."""
        devices = self._raw.devices.values()
        return {device.name: device.commands for device in devices if isinstance(device, MockActuator)}

    @property
    def logged(self) -> dict[str, list[Logged]]:
        """The values that the app has logged, by name, in their order."""
        logged: dict[str, list[Logged]] = {}
        for tick in self.ticks:
            for name, (value, _) in tick.logged.items():
                logged.setdefault(name, []).append(value)
        return logged

    @property
    def pictures(self) -> list[Image]:
        """The pictures that the app has shown, in their order."""
        devices = self._raw.devices.values()
        return [picture for device in devices if isinstance(device, MockDisplay) for picture in device.pictures]

    @cached_property
    def _raw(self) -> Robot:
        backend, names = self._backend, frozenset(device.name for device in self.description.devices)
        if app := self._app:
            names = choose_devices(
                backend, self.description, {}, app.needs, app.wants, remedy="Give MockRobot its script in readings"
            )
        return backend.open(Setup(self.description, None, names, self.rate_hz))

    @cached_property
    def _assembled(self) -> AssembledRobot:
        raw, seed = self._raw, self._seed
        planned = plan_faults(self._faults, self.description, raw.devices)
        faults = [fault.layer(raw.clock, seed) for fault in planned]
        return assemble(raw, self.description, self.rate_hz, seed=seed, faults=faults)

    def _find_first(self, role: Role) -> str:
        """Return the name of the device that fills a role."""
        if device := self.description.first_of(role.kind):
            return str(device.name)
        raise UnmetNeedError(
            f"{self.description.name} has no {role.kind.replace('_', ' ')} for the script. Add one to its description, "
            "or leave the script out",
            kind="no-device-for-script",
        )

    def _record_tick(self, record: TickRecord) -> None:
        self.ticks.append(record)
        drive, commands = self.description.drive, self.commands
        if drive and set(drive.motors) <= commands.keys():
            sides = drive.left_motors[0], drive.right_motors[0]
            last = (commands[name][-1].velocity if commands[name] else 0.0 for name in sides)
            self.wheels.append(Wheels(*last))
