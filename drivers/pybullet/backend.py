"""Bullet's rigid-body physics through PyBullet, in this process."""

from __future__ import annotations

import platform
import sys
from contextlib import ExitStack
from typing import Any

from pydantic import PositiveInt

from robotcore.backend import Backend, Setup, Vouch
from robotcore.description import (
    CameraDescription,
    Described,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
)
from robotcore.devices import Device
from robotcore.display import MemoryDisplay
from robotcore.errors import UsageError
from robotcore.robot import Robot


class PyBulletOptions(Described):
    """What ``--option`` can set."""

    solver_iterations: PositiveInt = 30


class PyBulletBackend(Backend):
    """Opens each robot in a simulation of its own, reproducible to the bit on one platform."""

    name = "pybullet"
    summary = "Bullet rigid-body physics, in process"
    vouches_for = frozenset({Vouch.CONTACTS, Vouch.POSE, Vouch.LOCKSTEP})
    needs_world = True
    has_gui = True
    modules = ("pybullet",)
