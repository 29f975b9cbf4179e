from __future__ import annotations

import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.deploy import push as push_module
from robotcore.deploy.agent.releases import Release
from robotcore.deploy.checks import CheckResult
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.progress import OnText, StepProgress
from robotcore.deploy.project import DeployOptions, build_project
from robotcore.deploy.push import PushRequest, describe_state_after, push
from robotcore.errors import DeployError, ReleaseCheckError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd
from tests.texts import CheckText, Raises

APP = """
from robotcore import Behaviour, Role, Status

class Still(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        return Status.SUCCESS
"""

OLD = "2026-11-21T22-40-03Z"

PROBE = """
def act(layout, requirements):
    assert "numpy>=1.24" in requirements
    return {
        "host": "rover", "machine": "aarch64", "system": "Debian 12", "python": "3.11.2", "free_bytes": 12_300_000_000,
        "has_environment": True, "libc": "glibc", "libc_version": "2.36",
    }
"""

INSTALL = """
from robotcore.deploy.agent.rpc import report_progress

def act(layout, release, is_offline):
    (layout.incoming / release).rename(layout.releases / release)
    report_progress("the doctor examines the robot")
    warning = {"level": "warning", "subject": "disk", "message": "nearly full", "remedy": "Make room"}
    good = {"level": "ok", "subject": "Python", "message": "3.11.2", "remedy": ""}
    return {"environment": "kept", "findings": [good, warning]}
"""

FAIL = """
from robotcore.deploy.agent.errors import AgentError

def act(layout, **arguments):
    raise AgentError("pip cannot reach its index", "Push with --offline", "network")
"""

ACTIVATE = """
import os

def act(layout, release, healthy_within_s):
    assert healthy_within_s == 7.0
    layout.current.unlink(missing_ok=True)
    layout.current.symlink_to(f"releases/{release}")
    return {
        "release": release, "outcome": "healthy", "reason": "", "lines": [], "current": release, "is_running": True,
        "is_stopped": False,
    }
"""


@pytest.fixture(scope="module")
def push_request(robot: Sshd, tmp_path_factory: pytest.TempPathFactory) -> PushRequest:
    """A push of a small project."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "still.py").write_text(APP)
    project = build_project(DeployOptions(app="still.py", robot="rover", backend="kinematic"), folder)
    return PushRequest(robot.address, project, is_checked=False, healthy_within_s=7.0)


@pytest.fixture(autouse=True)
def without_systemd(add_action: AddAction, robot: Sshd) -> None:
    """Replace the actions that use systemd and pip, and clear the robot. Uploads and files are real."""
    shutil.rmtree(robot.home / "robotcore", ignore_errors=True)
    for name, source in {"probe": PROBE, "install": INSTALL, "activate": ACTIVATE}.items():
        add_action(name, source)


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give each new release the same name."""
    make = push_module.create_release
    monkeypatch.setattr(push_module, "create_release", lambda *arguments: replace(make(*arguments), name=OLD))


def list_folders(robot: Sshd, below: str) -> set[str]:
    return {path.name for path in (robot.home / "robotcore" / below).glob("*") if path.is_dir()}


@pytest.mark.slow
def test_push_reports_each_step_and_sends_only_changes_again(push_request: PushRequest, robot: Sshd) -> None:
    steps: list[StepProgress] = []
    before = push(push_request, lambda _: None)
    release = push(push_request, steps.append)
    done = {each.step: each for each in steps if each.is_done}
    assert list(done) == ["skipped", "robot", "sent", "environment", "doctor", "release"]
    assert done["robot"].text == "rover: aarch64, Debian 12, Python 3.11.2, 12.3 GB free"
    assert ", 1 of them new," in done["sent"].text  # release.json
    assert done["doctor"].text == "1 ok, 1 warning"
    assert done["doctor"].details == ("warning: disk: nearly full. Make room",)
    assert done["release"].text == f"{release} is healthy; it runs"
    current = robot.home / "robotcore" / "current"
    assert (current / "project" / "still.py").read_text() == APP
    assert Release.read(current).name == release > before


@pytest.mark.slow
def test_push_connects_again_if_the_connection_breaks_during_the_checks(push_request: PushRequest, robot: Sshd) -> None:
    others = set(robot.connections())

    def break_connection(progress: StepProgress) -> None:
        if progress.step == "files":
            for pid in set(robot.connections()) - others:
                os.kill(pid, signal.SIGKILL)

    assert push(push_request, break_connection)


@pytest.mark.slow
def test_offline_push_sends_the_wheels(
    push_request: PushRequest, robot: Sshd, add_action: AddAction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "widget.whl").write_text("machine code")
    monkeypatch.setattr(push_module, "fetch_wheels", lambda *_: tmp_path)
    add_action("probe", PROBE.replace('"has_environment": True', '"has_environment": False'))
    release = push(replace(push_request, is_offline=True), lambda _: None)
    assert (robot.home / "robotcore" / "releases" / release / "wheels" / "widget.whl").read_text() == "machine code"


@pytest.mark.slow
def test_release_that_cannot_be_installed_is_deleted_and_the_current_one_stays(
    push_request: PushRequest, robot: Sshd, add_action: AddAction, raises: Raises
) -> None:
    root = robot.home / "robotcore"
    (root / "releases" / OLD).mkdir(parents=True)
    (root / "current").symlink_to(f"releases/{OLD}")
    before = (list_folders(robot, "releases"), (root / "current").readlink())
    add_action("install", FAIL)
    with raises(DeployError, "network"):
        push(push_request, lambda _: None)
    assert list_folders(robot, "incoming") == set()
    assert (list_folders(robot, "releases"), (root / "current").readlink()) == before


def test_nothing_is_sent_before_every_check_is_passed(
    push_request: PushRequest, robot: Sshd, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def fail(_project: object, report: OnText) -> CheckResult:
        raise ReleaseCheckError("simulation: 1 of 3 verified", kind="run-failed")

    for name in ("run_tests", "check_descriptions"):
        monkeypatch.setattr(push_module, name, lambda _project, _report: CheckResult("12 passed"))
    monkeypatch.setattr(push_module, "simulate", fail)
    before = [list_folders(robot, below) for below in ("releases", "incoming")]
    steps: list[StepProgress] = []
    with raises(ReleaseCheckError, "run-failed"):
        push(replace(push_request, is_checked=True), steps.append)
    assert [each.step for each in steps] == [
        "robot",
        "tests",
        "tests",
        "check",
        "check",
        "files",
        "files",
        "simulation",
    ]
    assert steps[2] == StepProgress("tests", "12 passed", is_done=True)
    assert [list_folders(robot, below) for below in ("releases", "incoming")] == before


@pytest.mark.parametrize("step", ["", "robot", "tests", "files", "simulation", "sent", "doctor", "release"])
def test_interrupted_push_describes_the_state_of_the_robot(
    push_request: PushRequest, step: str, check_text: CheckText
) -> None:
    check_text(describe_state_after(step, replace(push_request, host=RobotAddress("rover"))))
