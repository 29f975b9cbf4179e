"""The steps of a push, as they are seen on the robot from outside, and a deed in the middle of one."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

from tests.system.deploy.motors import awaited
from tests.system.deploy.projects import carrying, needing
from tests.system.deploy.rover import Ran, Rover
from tests.system.speed import scaled

RAD_S = 2.0
HEAVY_MB = 40
"""Takes a moment to send."""

ENDING_S = 120
"""Of what is left of a push, on the reference machine: a hang."""

SIGNS = {
    "sent": "incoming/*/project/.heavy.bin.*",
    "environment": "environments/*/bin/pip",
    "doctor": "incoming/*/environment",
}
"""What is there on the robot in a step, and was not before; in the last one, the new release is in place."""

STEPS = (*SIGNS, "release")


def interrupted(rover: Rover, step: str, deed: Callable[[subprocess.Popen[str]], object]) -> Ran:
    """Push what has to take this step, and do the deed in the middle of it; return what came of the push."""
    change = needing(rover.project) if step == "environment" else carrying(rover.project, HEAVY_MB)
    before = _seen(rover, step)
    with change, rover.pushing("--set", f"speed_rad_s={RAD_S:g}") as push:
        awaited(lambda: 1 if _seen(rover, step) - before else None, f"the step {step!r}", push.poll)
        deed(push)
        out, err = push.communicate(timeout=scaled(ENDING_S))
        return Ran(push.args, push.returncode, out, err)


def require_either(rover: Rover, driving: int, before: str, step: str) -> None:
    """The very process that drove drives on; or, once a new release was in place, a process of that one."""
    rover.await_judged()
    if step == "release":
        assert rover.release > before
        rover.motors.await_driving(RAD_S, instead_of=driving)
    else:
        assert (rover.release, rover.process) == (before, driving)
        assert rover.motors.await_driving(RAD_S) == driving


def _seen(rover: Rover, step: str) -> set[str]:
    return {rover.release} if step == "release" else set(map(str, rover.files.glob(SIGNS[step])))
