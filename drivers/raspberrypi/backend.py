"""The backend `raspberrypi`: the real robot, on the pins, buses and ports of this Raspberry Pi."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, ClassVar

from drivers.raspberrypi.chip import AT_THE_DESK, INSTALL, ON_THE_PI
from drivers.raspberrypi.header import build_wiring, resolve_pins
from drivers.raspberrypi.pins import open_pins
from robotcore.description import RobotDescription, StrictModel
from robotcore.errors import BackendError, BackendMissingError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Connection, DeviceBinding, HardwareBackend, open_robot
from robotcore.system import require_linux

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding
    from robotcore.hal.loopback import LoopbackRequest, LoopbackTest
    from robotcore.hal.wiring import Wiring


class RaspberryPiBackend(HardwareBackend):
    """Opens robots on the pins, buses and ports of this Raspberry Pi."""

    name = "raspberrypi"
    section = "raspberrypi"
    is_smoke_tested = False
    summary = "the real robot: motors and sensors on a Pi's pins, its cameras, its buses and ports"
    modules: ClassVar[tuple[str, ...]] = ("gpiozero", "lgpio")

    @property
    def remedy(self) -> str:
        return INSTALL

    def require_installed(self) -> None:
        if not self.needs_world:  # virtual pins need no kernel
            self._require_kernel()
        super().require_installed()

    def _require_kernel(self) -> None:
        require_linux(f"the backend {self.name!r}", "the GPIO chips and buses of Linux", AT_THE_DESK)

    def place(self, connection: Connection) -> Sequence[Connection]:
        return resolve_pins(connection)

    def summarize(self, bindings: Sequence[DeviceBinding]) -> str:
        """Return a text with the numbers of devices and wires, such as ``6 devices, 14 wires``."""
        return f"{len(bindings)} devices, {sum(len(binding.driver.connections()) for binding in bindings)} wires"

    def configure(self, setup: Setup) -> Setup:
        setup.options_as(StrictModel)  # it has no options
        return setup

    @property
    def is_native_host(self) -> bool:
        from drivers.raspberrypi.doctor import is_raspberry_pi

        return not self.needs_world and is_raspberry_pi()  # virtual pins need no board

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.raspberrypi.doctor import examine
        from robotcore.hal.check_finding import findings_of
        from robotcore.hardware.diagnosis import diagnose_monitored

        batteries = [("battery", partial(diagnose_monitored, self, robot))] if robot and self.is_native_host else []
        return chain(examine(self, robot), findings_of(batteries))

    def plan_loopback(self, request: LoopbackRequest) -> LoopbackTest:
        if self.needs_world:  # virtual pins have no wires
            return super().plan_loopback(request)
        self._require_kernel()
        from drivers.raspberrypi.loopback.raspberry_pi import PiLoopbackTest

        if not self.is_installed:
            raise BackendMissingError(f"the loopback test needs {' and '.join(self.modules)}. {ON_THE_PI}")
        test = PiLoopbackTest(request, self.bind(request.robot) if request.robot else ())
        try:
            open_pins().close()  # the person connects nothing if the pins cannot be used
        except BackendError as error:
            text = str(error).removesuffix(f". {AT_THE_DESK}")
            raise BackendError(f"{text}. Run the loopback test on a Raspberry Pi", kind=error.kind) from error
        return test

    def wiring(self, robot: RobotDescription) -> Wiring:
        bindings, left_out = self.bind_for_wiring(robot)
        wiring = build_wiring(bindings)
        return replace(wiring, notes=(*wiring.notes, *left_out))

    def open(self, setup: Setup) -> Robot:
        self.require_installed()
        setup = self.configure(setup)
        bindings = self.bind(setup.robot, setup.devices)
        pins = open_pins()
        return open_robot(setup, bindings, MonotonicClock(), pins=pins, release=pins.close)
