"""Each way in which a release can be broken: the one before runs again, and the reason is told."""

from __future__ import annotations

import pytest

from tests.system.deploy.projects import rewritten
from tests.system.deploy.rover import Ran, Rover

RAD_S, BROKEN_RAD_S = 2.0, 7.0
SOON = ("--healthy-within", "6")
APP = "onwards.py"
FAULTS = {
    "raises at once": (("deed=raises",), "no ball today"),
    "raises while it is looked at": (("deed=raises", "at=30"), "no ball today"),
    "leaves without a word": (("deed=leaves",), "9"),
    "hangs in its first step": (("deed=hangs",), ""),
    "does not come up": (("deed=dawdles",), "6 s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_release_that_does_not_live_is_rolled_back_with_its_reason(rover: Rover, fault: str) -> None:
    settings, reason = FAULTS[fault]
    options = [word for setting in (f"speed_rad_s={BROKEN_RAD_S:g}", *settings) for word in ("--set", setting)]
    require_rolled_back(rover, reason, *options)


@pytest.mark.parametrize(
    "line, reason", [("import nowhere_to_be_found", "nowhere_to_be_found"), ("def (:", "SyntaxError")]
)
def test_app_that_python_does_not_take_is_rolled_back_with_its_reason(rover: Rover, line: str, reason: str) -> None:
    app = rover.project / APP
    with rewritten(app, f"{app.read_text()}\n{line}\n"):
        require_rolled_back(rover, reason)


def require_rolled_back(rover: Rover, reason: str, *arguments: str) -> None:
    """Push what does not live; the release that drives now has to drive again, and the motors stood in between."""
    rover.done("start")
    driving, release = rover.motors.await_driving(RAD_S), rover.release
    ran: Ran = rover.push(*SOON, *arguments)
    assert (ran.returncode, rover.release) == (1, release), f"{ran.stdout}{ran.stderr}"
    assert reason in ran.stderr
    assert f"{release} runs again" in ran.stderr
    again = rover.motors.await_driving(RAD_S, instead_of=driving)
    assert rover.motors.stood_between(driving, again)
