from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from robotcore.deploy import health
from robotcore.deploy.answers import HealthResult
from robotcore.deploy.host import Host, command_hint
from robotcore.deploy.progress import Progress, begin_step
from robotcore.deploy.rpc import Link
from robotcore.errors import DeployError, UnhealthyError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, serving

OLD, NEW = "2026-11-21T22-40-03Z", "2026-11-21T22-52-10Z"

JUDGED = """
def act(layout, release, **arguments):
    return {judgement!r}
"""

GOES_ON = """
import time
from robotcore.deploy.agent.rpc import report_progress

def act(layout, release, healthy_within_s):
    release = release or "2026-11-21T22-40-03Z"
    begun = layout.home / "begun"
    if begun.exists():
        return {"release": release, "outcome": "healthy", "reason": "", "lines": [], "current": release,
                "is_running": True, "is_standing": False}
    begun.touch()
    report_progress("it starts", release=release)
    time.sleep(600)
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sshd]:
    with serving(tmp_path_factory.mktemp("robot") / "sshd") as server:
        yield server


@pytest.fixture(scope="module")
def link(robot: Sshd) -> Iterator[Link]:
    with Link(Host(robot.host), robot.config) as link:
        yield link


@pytest.fixture(autouse=True)
def prompt(monkeypatch: pytest.MonkeyPatch, robot: Sshd) -> None:
    monkeypatch.setattr(health, "PAUSE_S", 0.01)
    (robot.home / "begun").unlink(missing_ok=True)


def follow(link: Link, robot: Sshd, release: str | None = NEW) -> list[Progress]:
    """Follow a trial; return what is told of it."""
    steps: list[Progress] = []
    watched = health.HealthCheck(link.host, robot.config, begin_step(health.STEP, steps.append))
    watched.follow(link, "activate", release, healthy_within_s=5.0)
    return steps


def follow_cut(robot: Sshd, action: str = "activate", release: str | None = NEW) -> list[Progress]:
    """Follow a trial over a connection that breaks as soon as the robot says something."""
    steps: list[Progress] = []

    def hear(progress: Progress) -> None:
        steps.append(progress)
        if progress.text == "it starts":
            os.kill(robot.connections()[-1], signal.SIGKILL)

    with Link(Host(robot.host), robot.config) as link:
        watched = health.HealthCheck(link.host, robot.config, begin_step(health.STEP, hear))
        watched.follow(link, action, release, healthy_within_s=5.0)
    return steps


def judgement(
    outcome: str, reason: str = "", current: str | None = NEW, *, is_running: bool = True, is_standing: bool = False
) -> str:
    lines = ["ZeroDivisionError: float division by zero"] if reason else []
    result = {
        "outcome": outcome,
        "reason": reason,
        "current": current,
        "is_running": is_running,
        "is_standing": is_standing,
    }
    return JUDGED.format(judgement={"release": NEW, "lines": lines, **result})


def test_release_that_lives_is_reported_to_run(link: Link, robot: Sshd, add_action: AddAction) -> None:
    add_action("activate", judgement("healthy"))
    assert follow(link, robot)[-1] == Progress("release", f"{NEW} is healthy; it runs", is_done=True)


def test_release_that_has_ended_well_is_reported_to_have_ended(link: Link, robot: Sshd, add_action: AddAction) -> None:
    add_action("activate", judgement("healthy", "it ended with success", is_running=False))
    assert follow(link, robot)[-1].text == f"{NEW} is healthy; it ended with success"


@pytest.mark.parametrize(
    "current, is_running, is_standing, now",
    [
        (OLD, True, False, f"{OLD} runs again"),
        (OLD, False, True, f"{OLD} is in place again, and stands as before"),
        (OLD, False, False, f"{OLD} is in place again, and does not run either"),
        (None, False, True, "Nothing runs"),
    ],
)
def test_release_that_does_not_live_is_reported_with_its_last_words_and_what_runs_now(
    link: Link, robot: Sshd, add_action: AddAction, current: str | None, is_running: bool, is_standing: bool, now: str
) -> None:
    judged = judgement("unhealthy", "it ended with status 5", current, is_running=is_running, is_standing=is_standing)
    add_action("activate", judged)
    with pytest.raises(UnhealthyError) as caught:
        follow(link, robot)
    assert f"{NEW} did not live: it ended with status 5. {now}" in str(caught.value)
    assert str(caught.value).splitlines()[1:] == ["  ZeroDivisionError: float division by zero"]


@pytest.mark.parametrize(
    "error, reason",
    [
        ("Search raised ZeroDivisionError: 1", "Search raised ZeroDivisionError: 1. Nothing runs"),
        (
            "ModuleNotFoundError: No module named 'a'",
            "No module named 'a'. Add it to dependencies in pyproject.toml. N",
        ),
    ],
)
def test_headline_has_the_error_that_robotcore_reported(error: str, reason: str) -> None:
    lines = ["Traceback (most recent call last):", f"error: {error}", "error: the recording is not whole"]
    came = {"release": NEW, "outcome": "unhealthy", "reason": "the app raised", "lines": lines, "current": None}
    judged = HealthResult.model_validate({**came, "is_running": False, "is_standing": True})
    said = health._format_failure(Host("robot"), judged, "logs").splitlines()
    assert reason in said[0]
    assert said[0].startswith(f"robot: {NEW} did not live: the app raised: ")
    assert said[1:] == [f"  {line}" for line in lines]


def test_broken_connection_is_made_anew_and_the_trial_is_followed_to_its_end(
    robot: Sshd, add_action: AddAction
) -> None:
    add_action("activate", GOES_ON)
    steps = follow_cut(robot)
    assert "broke" in steps[-2].text
    assert steps[-1].text == f"{NEW} is healthy; it runs"


def test_release_that_the_robot_chose_is_found_again_by_the_name_that_it_said(
    robot: Sshd, add_action: AddAction
) -> None:
    for action in ("activate", "rollback"):
        add_action(action, GOES_ON)
    assert follow_cut(robot, "rollback", None)[-1].text == f"{OLD} is healthy; it runs"


def test_robot_that_does_not_come_back_is_reported_with_how_to_look(
    robot: Sshd, add_action: AddAction, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(health, "ATTEMPTS", 0)
    add_action("activate", GOES_ON)
    with pytest.raises(
        DeployError, match=f"goes on there: {command_hint('status', Host('robot'), robot.config)}"
    ) as caught:
        follow_cut(robot)
    assert not isinstance(caught.value, UnhealthyError)


def test_refusal_is_no_reason_to_look_again(link: Link, robot: Sshd, add_action: AddAction) -> None:
    add_action(
        "activate",
        """
from robotcore.deploy.agent.rpc import AgentError

def act(layout, **arguments):
    raise AgentError("somebody else is at it", "Wait for it", "busy")
""",
    )
    with pytest.raises(DeployError, match=r"somebody else is at it\. Wait for it$"):
        follow(link, robot)
