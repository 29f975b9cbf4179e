"""A backend tried out: a simulated robot opens, moves and sees."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

from robotcore.description import RobotDescription, load_robot, load_world
from robotcore.errors import DescriptionError, DeviceGroupError, RobotcoreError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot, Role

ROBOT, WORLD = "rover", "open"
TRIAL_S = 0.25
"""Of simulated time: long enough for any motor to have turned a wheel."""

VELOCITY_RAD_S = 2.0


def diagnose(backend: Backend, robot: RobotDescription | None = None) -> Iterator[Finding]:
    """Yield a smoke test of the backend if it takes one, and then the backend's own findings."""
    if backend.is_smoke_tested:
        yield from smoke_test(backend, robot)
    yield from backend.examine(robot)


def smoke_test(backend: Backend, robot: RobotDescription | None) -> Iterator[Finding]:
    """Yield whether a backend is installed and, if it simulates, whether this robot opens, moves and sees in it."""
    if not backend.is_installed:
        yield Finding.warning(backend.name, "is not installed", backend.remedy)
        return
    if not backend.needs_world:
        yield Finding.ok(backend.name, "is installed")
        return
    yield _tried(backend, robot or load_robot(ROBOT))
    if backend.has_gui:
        yield _display(backend.name)


def _tried(backend: Backend, robot: RobotDescription) -> Finding:
    setup = Setup(robot, load_world(WORLD), frozenset(device.name for device in robot.devices))
    try:
        with backend.open(setup) as opened:
            return _driven(backend.name, opened)
    except DescriptionError as error:
        others = f", and {len(error.others)} more" if error.others else ""
        said = f"cannot open {error.file}: {error.key}: {error.fault}{others}"
        return Finding.error(backend.name, said, f"robotcore check {robot.file or robot.name}")
    except DeviceGroupError as error:
        return _unopened(backend, "; ".join(map(str, error.failures)))
    except RobotcoreError as error:
        return _unopened(backend, str(error))
    except Exception as error:  # noqa: BLE001  a simulator of another build raises anything
        text = " ".join(str(error).split())
        return Finding.error(backend.name, f"does not work: {type(error).__name__}: {text}", backend.remedy)


def _unopened(backend: Backend, text: str) -> Finding:
    """Return an error in its own words, which end with what to do about it, if anybody knows."""
    fault, _, remedy = text.rpartition(". ")
    if not fault:
        return Finding.error(backend.name, text, f"Try robotcore run green-search --backend {backend.name}")
    return Finding.error(backend.name, fault, remedy)


def _driven(name: str, robot: Robot) -> Finding:
    """Let all motors turn and the camera see; what moved is the simulator's word."""
    done = ["opens"]
    before = robot.truth.pose() if robot.truth else None
    for motor in robot.motors.values():
        motor.set_velocity(VELOCITY_RAD_S)
    robot.clock.sleep_until(TRIAL_S)
    if robot.motors and robot.truth:
        if robot.truth.pose() == before:
            return Finding.error(name, "opens, but nothing moves", "Install it again")
        done.append("moves")
    if robot.has(Role.RANGE):
        robot.range.read()
        done.append("measures")
    if robot.has(Role.CAMERA):
        height, width = robot.camera.read().image.shape[:2]
        done.append(f"renders {width} x {height} pixels")
    return Finding.ok(name, f"{', '.join(done)}, closes")


def _display(name: str) -> Finding:
    """Look whether a window could open; Linux tells by its environment."""
    if not sys.platform.startswith("linux"):
        return Finding.ok("display", f"--backend {name} --gui opens its window")
    if display := os.environ.get("DISPLAY"):
        return Finding.ok("display", f"--backend {name} --gui opens its window on {display}, if that is there")
    remedy = "Sit at the machine, or take ssh -X; without a window: --picture FILE.png"
    return Finding.warning("display", f"there is none: --backend {name} --gui opens no window", remedy)
