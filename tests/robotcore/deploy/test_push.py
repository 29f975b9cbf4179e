from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.deploy import checks, simulation
from robotcore.deploy import push as push_module
from robotcore.deploy.agent.releases import Release
from robotcore.deploy.checks import Check, CheckResult
from robotcore.deploy.host import Host
from robotcore.deploy.progress import Progress, Say
from robotcore.deploy.project import DeployOptions, build_project
from robotcore.deploy.push import Push, describe_state_after, push
from robotcore.deploy.wheels import Target
from robotcore.errors import DeployError, DescriptionError, UnprovenError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, serving

APP = """
from robotcore import Behaviour, Role, Status

class Still(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        return Status.SUCCESS
"""

OLD = "2026-11-21T22-40-03Z"

PROBE = """
def act(layout, requirements, is_push):
    assert is_push and "numpy>=1.24" in requirements
    return {
        "host": "rover", "machine": "aarch64", "system": "Debian 12", "python": "3.11.2", "free_bytes": 12_300_000_000,
        "has_environment": True, "libc": "glibc", "libc_version": "2.36",
    }
"""

INSTALL = """
from robotcore.deploy.agent.rpc import report_progress

def act(layout, release, is_offline):
    (layout.incoming / release).rename(layout.releases / release)
    report_progress("doctor looks at the robot")
    fault = {"level": "warning", "what": "disk", "said": "nearly full", "remedy": "Make room"}
    good = {"level": "ok", "what": "Python", "said": "3.11.2", "remedy": ""}
    return {"environment": "kept", "findings": [good, fault]}
"""

FAIL = """
from robotcore.deploy.agent.rpc import AgentError

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
        "is_standing": False,
    }
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sshd]:
    with serving(tmp_path_factory.mktemp("robot") / "sshd") as server:
        yield server


@pytest.fixture(scope="module")
def wanted(robot: Sshd, tmp_path_factory: pytest.TempPathFactory) -> Push:
    """A push of a small project."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "still.py").write_text(APP)
    project = build_project(DeployOptions(app="still.py", robot="rover", backend="kinematic"), folder)
    return Push(Host(robot.host), project, robot.config, is_checked=False, healthy_within_s=7.0)


@pytest.fixture(autouse=True)
def without_systemd(add_action: AddAction) -> None:
    """Leaves out systemd and pip on the robot; what is sent and kept is for real."""
    for name, source in {"probe": PROBE, "install": INSTALL, "activate": ACTIVATE}.items():
        add_action(name, source)


@pytest.fixture(autouse=True)
def a_clock_that_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets the desk's time be always the same."""
    make = push_module.new_release
    monkeypatch.setattr(push_module, "new_release", lambda *arguments: replace(make(*arguments), name=OLD))


def rooms(robot: Sshd, room: str) -> set[str]:
    return {path.name for path in (robot.home / "robotcore" / room).glob("*") if path.is_dir()}


def test_each_step_is_reported_and_the_release_is_there_whole_and_only_changes_are_sent_again(
    wanted: Push, robot: Sshd
) -> None:
    steps: list[Progress] = []
    before = push(wanted, lambda _: None)
    release = push(wanted, steps.append)
    done = {each.step: each for each in steps if each.is_done}
    assert list(done) == ["skipped", "robot", "sent", "environment", "doctor", "release"]
    assert done["robot"].text == "rover: aarch64, Debian 12, Python 3.11.2, 12.3 GB free"
    assert ", 1 of them new," in done["sent"].text  # release.json
    assert done["doctor"].text == "1 ok, 1 warning"
    assert done["doctor"].notes == ("warning: disk: nearly full. Make room",)
    assert done["release"].text == f"{release} is healthy; it runs"
    current = robot.home / "robotcore" / "current"
    assert (current / "project" / "still.py").read_text() == APP
    assert Release.read(current).name == release > before


def test_wheels_go_with_the_release_that_needs_them(
    wanted: Push, robot: Sshd, add_action: AddAction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "widget.whl").write_text("machine code")
    monkeypatch.setattr(push_module, "fetch_wheels", lambda *_: tmp_path)
    add_action("probe", PROBE.replace('"has_environment": True', '"has_environment": False'))
    release = push(replace(wanted, is_offline=True), lambda _: None)
    assert (robot.home / "robotcore" / "releases" / release / "wheels" / "widget.whl").read_text() == "machine code"


def test_what_fails_to_install_is_thrown_away_and_what_runs_is_as_it_was(
    wanted: Push, robot: Sshd, add_action: AddAction
) -> None:
    root = robot.home / "robotcore"
    (root / "releases" / OLD).mkdir(parents=True, exist_ok=True)
    (root / "current").unlink(missing_ok=True)
    (root / "current").symlink_to(f"releases/{OLD}")
    before = (rooms(robot, "releases"), (root / "current").readlink())
    add_action("install", FAIL)
    with pytest.raises(DeployError, match=r"pip cannot reach its index\. Push with --offline"):
        push(wanted, lambda _: None)
    assert rooms(robot, "incoming") == set()
    assert (rooms(robot, "releases"), (root / "current").readlink()) == before


def test_nobody_is_called_before_every_gate_is_passed(wanted: Push, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_project: object, say: Say) -> CheckResult:
        raise UnprovenError("simulation: 1 of 3 verified")

    monkeypatch.setattr(checks, "CHECKS_OF_PROJECT", (Check("tests", lambda _project, _say: CheckResult("12 passed")),))
    monkeypatch.setattr(simulation, "CHECKS_OF_BUNDLE", (Check("simulation", fail),))
    steps: list[Progress] = []
    nowhere = replace(wanted, is_checked=True, host=Host("nobody.invalid"))
    with pytest.raises(UnprovenError, match="1 of 3"):
        push(nowhere, steps.append)
    assert [each.step for each in steps] == ["tests", "tests", "files", "files", "simulation"]
    assert steps[1] == Progress("tests", "12 passed", is_done=True)


@pytest.mark.parametrize(
    "step, state",
    [
        ("", "Nothing has changed on rover"),
        ("tests", "Nothing was sent to rover"),
        ("files", "Nothing was sent to rover"),
        ("simulation", "Nothing was sent to rover"),
        ("sent", "Nothing has changed on rover"),
        ("doctor", "Nothing has changed on rover"),
        ("release", "The trial goes on there: robotcore deploy status rover"),
    ],
)
def test_push_that_is_cut_short_says_what_it_leaves(wanted: Push, step: str, state: str) -> None:
    assert describe_state_after(step, replace(wanted, host=Host("rover"), ssh_config=None)) == state


def test_robot_whose_python_is_not_the_projects_is_sent_nothing(wanted: Push, robot: Sshd) -> None:
    before = rooms(robot, "releases")
    metadata = wanted.project.metadata.model_copy(update={"requires_python": ">=3.13"})
    with pytest.raises(DeployError) as raised:
        push(replace(wanted, project=replace(wanted.project, metadata=metadata)), lambda _: None)
    assert raised.value.kind == "python-version"
    assert (rooms(robot, "releases"), rooms(robot, "incoming")) == (before, set())


def test_a_python_that_is_no_version_is_wrong_in_the_projects_file(wanted: Push) -> None:
    metadata = wanted.project.metadata.model_copy(update={"requires_python": "three"})
    with pytest.raises(DescriptionError, match=r"project\.requires-python: 'three' names no versions"):
        Target("3.11.2", "aarch64").require_python(replace(wanted.project, metadata=metadata))
