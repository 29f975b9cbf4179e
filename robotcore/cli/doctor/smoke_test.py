"""The smoke test of a simulator: open a robot, move it, and read its sensors."""

from __future__ import annotations

import os
from collections.abc import Iterator

from robotcore.description import RobotDescription, load_robot, load_world
from robotcore.errors import DescriptionError, DeviceGroupError, RobotcoreError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Finding, Level
from robotcore.hal.robot import Robot, Role
from robotcore.system import IS_LINUX

ROBOT, WORLD = "rover", "open"
TEST_S = 0.25
"""Each motor turns its wheel for this simulated time, in seconds."""

VELOCITY_RAD_S = 2.0


def diagnose(backend: Backend, robot: RobotDescription | None = None) -> Iterator[Finding]:
    """Yield the findings of the backend's own checks, and then those of the smoke test, if the backend has one.

    A simulator that is not installed is not checked. If its own checks find that it does not work, there is no smoke
    test, because it would only repeat the problem.
    """
    if not backend.is_smoke_tested:
        yield from backend.examine(robot)
        return
    if not backend.is_installed:
        yield Finding.warning(backend.name, "is not installed", backend.remedy, kind="not-installed")
        return
    works = True
    for finding in backend.examine(robot):
        works = works and (finding.subject != backend.name or finding.level is Level.OK)
        yield finding
    if works:
        yield from smoke_test(backend, robot)


def smoke_test(backend: Backend, robot: RobotDescription | None) -> Iterator[Finding]:
    """Yield whether a simulator moves a robot, and can open a window.

    backend: the simulator, which is installed. Another backend is not tested.
    robot: the robot to move; None for the rover.
    """
    if not backend.needs_world:
        yield Finding.ok(backend.name, "is installed", kind="installed")
        return
    yield _try_robot(backend, robot or load_robot(ROBOT))
    if backend.has_gui:
        yield _check_display(backend.name)


def _try_robot(backend: Backend, robot: RobotDescription) -> Finding:
    setup = Setup(robot, load_world(WORLD), frozenset(device.name for device in robot.devices))
    try:
        with backend.open(setup) as opened:
            return _drive(backend.name, opened)
    except DescriptionError as error:
        others = f", and {len(error.others)} more" if error.others else ""
        text = f"cannot open {error.file}: {error.key}: {error.problem}{others}"
        # `robotcore check` does not miss a section, because it checks only those in the file
        remedy = error.remedy if error.kind == "no-section" else f"robotcore check {robot.file or robot.name}"
        return Finding.error(backend.name, text, remedy, kind=error.kind)
    except RobotcoreError as error:
        text = "; ".join(map(str, error.failures)) if isinstance(error, DeviceGroupError) else str(error)
        problem, remedy = split_remedy(text)
        remedy = remedy or f"Try robotcore run green-search --backend {backend.name}"
        return Finding.error(backend.name, problem, remedy, kind=error.kind)
    except Exception as error:  # noqa: BLE001  an incompatible build of a simulator may raise any exception
        text = " ".join(str(error).split())
        return Finding.error(
            backend.name, f"does not work: {type(error).__name__}: {text}", backend.remedy, kind="simulator-broken"
        )


def split_remedy(message: str) -> tuple[str, str]:
    """Return the problem and the remedy in an error message. The remedy is the last of several sentences.

    >>> split_remedy("no library. Install it"), split_remedy("no library")
    (('no library', 'Install it'), ('no library', ''))
    """
    problem, _, remedy = message.rpartition(". ")
    return (problem, remedy) if problem else (remedy, "")


def _drive(name: str, robot: Robot) -> Finding:
    """Turn all motors, and read the range sensor and the camera. Report an error if the true pose does not change."""
    done = ["opens"]
    before = robot.truth.pose() if robot.truth else None
    for motor in robot.motors.values():
        motor.set_velocity(VELOCITY_RAD_S)
    robot.clock.sleep_until(TEST_S)
    if robot.motors and robot.truth:
        if robot.truth.pose() == before:
            return Finding.error(name, "opens, but nothing moves", "Install it again", kind="nothing-moves")
        done.append("moves")
    if robot.has(Role.RANGE):
        robot.range.read()
        done.append("measures")
    if robot.has(Role.CAMERA):
        height, width = robot.camera.read().image.shape[:2]
        done.append(f"renders {width} x {height} pixels")
    text = f"{', '.join(done)}, closes"
    if robot.notes:
        problem, remedy = split_remedy(" ".join(robot.notes))
        return Finding.warning(name, f"{text}; {problem}", remedy, kind="works-with-notes")
    return Finding.ok(name, text, kind="works")


def _check_display(name: str) -> Finding:
    """Return whether a window can open. Only Linux shows this beforehand, by the variable DISPLAY."""
    if not IS_LINUX:
        return Finding.ok("display", f"--backend {name} --gui opens its window", kind="display")
    if display := os.environ.get("DISPLAY"):
        return Finding.ok(
            "display", f"--backend {name} --gui opens its window on display {display}, if it exists", kind="display"
        )
    remedy = "Log in at the machine, or use ssh -X. Without a window, use --picture FILE.png"
    return Finding.warning(
        "display", f"DISPLAY is not set, so --backend {name} --gui opens no window", remedy, kind="no-display"
    )
