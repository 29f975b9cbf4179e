"""A backend on simulated AVRs with our firmware, in the kinematic world: the drivers are those that ship."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from drivers.serial.backend import SECTION
from robotcore.backend import Backend, Setup, Vouch
from robotcore.clock import FollowingClock
from robotcore.description import CameraDescription, Described
from robotcore.devices import Device
from robotcore.hardware import open_robot
from robotcore.robot import Robot
from tests.system.firmware.board import Board
from tests.system.firmware.config import wiring
from tests.system.firmware.described import on_serial
from tests.system.firmware.wiring import Wiring
from tests.system.firmware.world import FollowedCamera, FollowedWorld

BUILT = "ROBOTCORE_FIRMWARE_BUILT"
"""The environment variable that names the folder with the simulator and the sketch."""

FOLLOW_S = 0.01


def built() -> Path:
    return Path(os.environ[BUILT])


def switched_on(change: Callable[[Wiring], Wiring] = lambda wiring: wiring) -> Board:
    """Return a board that runs our firmware, its robot wired as the sketch says; ``change`` builds it otherwise."""
    sketch = built() / "robotcore_bridge"
    return Board(built() / "simulated-avr", built() / "firmware.elf", change(wiring(sketch)))


class SimavrOptions(Described):
    """There are none."""


class SimavrBackend(Backend):
    """Opens robots on a simulated board: one that it switches on, or one that is on already."""

    name = "simavr"
    summary = "our firmware on a simulated AVR, in the kinematic world"
    vouches_for = frozenset({Vouch.CONTACTS, Vouch.POSE})
    needs_world = True

    def __init__(self, board: Board | None = None) -> None:
        self._board = board

    def open(self, setup: Setup) -> Robot:
        setup.options_as(SimavrOptions)
        with ExitStack() as undo:
            board = self._board or undo.enter_context(switched_on())
            clock = FollowingClock(board.now)
            world = FollowedWorld(setup, board)
            undo.callback(clock.every(FOLLOW_S, world.follow, "followed world").stop)
            release = undo.pop_all().close
        setup = replace(setup, robot=on_serial(setup.robot, board.port), options={})
        return open_robot(setup, SECTION, clock, release=release, truth=world, opened=_cameras(setup, world, clock))


def _cameras(setup: Setup, world: FollowedWorld, clock: FollowingClock) -> dict[str, Device]:
    return {
        told.name: FollowedCamera(told, world, clock) for told in setup.chosen if isinstance(told, CameraDescription)
    }
