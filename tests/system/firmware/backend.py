"""A backend with the serial drivers on a simulated board with robotcore_bridge, in the kinematic world."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from drivers.serial.backend import SECTION
from robotcore.description import RobotDescription, StrictModel
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import ServerClock
from robotcore.hardware import bind_devices, open_robot
from robotcore.kinds.camera import CameraDescription
from tests.system.firmware.board import Board
from tests.system.firmware.config import BOARD_TIMEOUT_S, on_serial, wiring
from tests.system.firmware.simulated import OnDemandClock, SimulatedRobot, Wiring, map_bench
from tests.system.firmware.world import FollowedCamera, FollowedWorld

BUILT = "ROBOTCORE_FIRMWARE_BUILT"
"""The environment variable with the folder of the simulator and the sketch."""

FOLLOW_S = 0.01


def build_folder() -> Path:
    return Path(os.environ[BUILT])


def start_board(change: Callable[[Wiring], Wiring] = lambda wiring: wiring) -> Board:
    """Return a running board with robotcore_bridge. ``change`` edits the wiring of its robot."""
    sketch = build_folder() / "robotcore_bridge"
    return Board(build_folder() / "simulated-avr", build_folder() / "firmware.elf", change(wiring(sketch)))


class SimavrOptions(StrictModel):
    """The options of the backend `simavr`."""

    board_timeout_s: float = BOARD_TIMEOUT_S
    join: Path | None = None
    """The folder of a board that another process runs."""


class SimavrBackend(Backend):
    """Opens robots on a simulated board: a new board, the constructor's board, or a board of another process."""

    name = "simavr"
    summary = "robotcore_bridge on a simulated AVR, in the kinematic world"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE})
    needs_world = True

    def __init__(self, board: Board | None = None) -> None:
        self._board = board

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return frozenset(device.name for device in robot.devices)

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(SimavrOptions)
        with ExitStack() as cleanup:
            simulated, clock = self._start_or_join(options.join, cleanup)
            world = FollowedWorld(setup, simulated)
            cleanup.callback(clock.call_every(FOLLOW_S, world.follow, "followed world").stop)
            release = cleanup.pop_all().close
        setup = replace(setup, robot=on_serial(setup.robot, simulated.port, options.board_timeout_s), options={})
        cameras = _cameras(setup, world, clock)
        bindings = bind_devices(setup.robot, SECTION, setup.devices - cameras.keys())
        return open_robot(setup, bindings, clock, release=release, truth=world, opened=cameras)

    def _start_or_join(self, join: Path | None, cleanup: ExitStack) -> tuple[SimulatedRobot, ServerClock]:
        if shared := self._board or (join and SimulatedRobot(join, map_bench(join))):
            return shared, ServerClock(shared.now)
        board = cleanup.enter_context(start_board())
        return board, OnDemandClock(board)


def _cameras(setup: Setup, world: FollowedWorld, clock: ServerClock) -> dict[str, Device]:
    return {
        device.name: FollowedCamera(device, world, clock)
        for device in setup.chosen_devices
        if isinstance(device, CameraDescription)
    }
