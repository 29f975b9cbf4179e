from __future__ import annotations

import os
import signal

import pytest

from robotcore.deploy import health_progress as health
from robotcore.deploy.errors import BROKEN
from robotcore.deploy.health_progress import RECONNECTING
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.progress import Step, StepProgress
from robotcore.deploy.robot_answers import HealthAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError, UnhealthyError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd
from tests.texts import CheckText, Raises

OLD, NEW = "2026-11-21T22-40-03Z", "2026-11-21T22-52-10Z"

LINES = ("ZeroDivisionError: float division by zero",)

ANSWER = """
def act(layout, release, **arguments):
    return {result!r}
"""

GOES_ON = """
import time
from robotcore.deploy.agent.rpc import report_progress

def act(layout, release, healthy_within_s):
    release = release or "2026-11-21T22-40-03Z"
    begun = layout.home / "begun"
    if begun.exists():
        return {"release": release, "outcome": "healthy", "reason": "", "lines": [], "current": release,
                "is_running": True, "is_stopped": False}
    begun.touch()
    report_progress("it starts", release=release)
    time.sleep(600)
"""


@pytest.fixture(autouse=True)
def prompt(monkeypatch: pytest.MonkeyPatch, robot: Sshd) -> None:
    monkeypatch.setattr(health, "PAUSE_S", 0.01)
    (robot.home / "begun").unlink(missing_ok=True)


def follow(link: RobotLink, robot: Sshd) -> list[StepProgress]:
    """Follow a health check; return its progress."""
    steps: list[StepProgress] = []
    health.follow_check(link, Step(health.STEP, steps.append), "activate", NEW, 5.0)
    return steps


def follow_broken_connection(robot: Sshd, action: str = "activate", release: str | None = NEW) -> list[StepProgress]:
    """Follow a health check over a connection that breaks at the first progress message."""
    steps: list[StepProgress] = []
    others = set(robot.connections())

    def break_connection(progress: StepProgress) -> None:
        steps.append(progress)
        if progress.text == "it starts":
            for pid in set(robot.connections()) - others:
                os.kill(pid, signal.SIGKILL)

    with RobotLink(robot.address) as link:
        health.follow_check(link, Step(health.STEP, break_connection), action, release, 5.0)
    return steps


def answer(
    outcome: str, reason: str = "", current: str | None = NEW, *, is_running: bool = True, is_standing: bool = False
) -> str:
    lines = list(LINES) if reason else []
    result = {
        "outcome": outcome,
        "reason": reason,
        "current": current,
        "is_running": is_running,
        "is_stopped": is_standing,
    }
    return ANSWER.format(result={"release": NEW, "lines": lines, **result})


def test_healthy_release_is_reported_as_running(link: RobotLink, robot: Sshd, add_action: AddAction) -> None:
    add_action("activate", answer("healthy"))
    assert follow(link, robot)[-1] == StepProgress("release", f"{NEW} is healthy; it runs", is_done=True)
    add_action("activate", answer("healthy", "it ended with success", is_running=False))
    assert follow(link, robot)[-1].text == f"{NEW} is healthy; it ended with success"


@pytest.mark.parametrize(
    "current, is_running, is_standing",
    [(OLD, True, False), (OLD, False, True), (OLD, False, False), (None, False, True)],
    ids=["runs", "stopped", "failed", "none"],
)
def test_unhealthy_release_raises_with_its_last_lines_and_the_current_release(
    link: RobotLink,
    robot: Sshd,
    add_action: AddAction,
    raises: Raises,
    current: str | None,
    is_running: bool,
    is_standing: bool,
) -> None:
    result = answer("unhealthy", "it ended with status 5", current, is_running=is_running, is_standing=is_standing)
    add_action("activate", result)
    with raises(UnhealthyError, release=NEW, current=current, lines=LINES, hide=[robot.config]):
        follow(link, robot)


@pytest.mark.parametrize(
    "error",
    ["Search raised ZeroDivisionError: 1", "ModuleNotFoundError: No module named 'a'"],
    ids=["error", "missing package"],
)
def test_message_begins_with_the_error_of_robotcore(error: str, check_text: CheckText) -> None:
    lines = ["Traceback (most recent call last):", f"error: {error}", "error: the recording is not whole"]
    fields = {"release": NEW, "outcome": "unhealthy", "reason": "the app raised", "lines": lines, "current": None}
    result = HealthAnswer.model_validate({**fields, "is_running": False, "is_stopped": True})
    check_text(health._format_failure(RobotAddress("robot"), result))


@pytest.mark.slow
def test_client_connects_again_and_resumes_with_the_release_that_the_robot_chose(
    robot: Sshd, add_action: AddAction
) -> None:
    for action in ("activate", "rollback"):
        add_action(action, GOES_ON)
    steps = follow_broken_connection(robot, "rollback", None)
    assert RECONNECTING in [step.text for step in steps]
    assert steps[-1].text == f"{OLD} is healthy; it runs"


@pytest.mark.slow
def test_lost_robot_is_an_error_with_the_command_for_its_status(
    robot: Sshd, add_action: AddAction, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(health, "ATTEMPTS", 0)
    add_action("activate", GOES_ON)
    with pytest.raises(DeployError) as caught:
        follow_broken_connection(robot)
    assert type(caught.value) is DeployError
    assert caught.value.kind == BROKEN
    assert robot.address.format_command("status") in str(caught.value)


@pytest.mark.parametrize("kind, attempts", [("denied", 1), ("host-key-changed", 1), ("time-out", health.ATTEMPTS)])
def test_client_connects_again_only_if_that_may_succeed(
    robot: Sshd, monkeypatch: pytest.MonkeyPatch, kind: str, attempts: int
) -> None:
    kinds: list[str] = []

    def fail(failure: str) -> None:
        kinds.append(failure)
        raise DeployError("it failed", kind=failure)

    link = RobotLink(RobotAddress("robot"))
    monkeypatch.setattr(link, "call", lambda *_, **__: fail(BROKEN))
    monkeypatch.setattr(link, "reconnect", lambda: fail(kind))
    with pytest.raises(DeployError) as caught:
        follow(link, robot)
    assert caught.value.kind == kind
    assert kinds == [BROKEN, *[kind] * attempts]


def test_client_does_not_connect_again_after_a_refusal(
    link: RobotLink, robot: Sshd, add_action: AddAction, raises: Raises
) -> None:
    add_action(
        "activate",
        """
from robotcore.deploy.agent.errors import AgentError

def act(layout, **arguments):
    raise AgentError("another deploy is at work", "Wait for it", "busy")
""",
    )
    with raises(DeployError, "busy"):
        follow(link, robot)
