"""The CI of a new project: its workflow files run ``ci.sh``, whose checks pass, and fail if the app is wrong."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from robotcore.cli.scaffold import DRIVER, KIND, PROJECT, Template, make
from tests.robotcore.cli.scaffold.test_first_commands import HOME
from tests.robotcore.junit_schema import read_junit

RECORD = "robotcore run search.py --robot scout.toml --world room.toml --seed 7 --record recordings/seed-7.mcap"
"""The command in ``recordings/README.md``."""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "all my robots" / "scout"
    folder.parent.mkdir()
    make(PROJECT, folder)
    return folder


def type_line(folder: Path, line: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a line of a shell in a folder, with robotcore installed."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(HOME), "PYTHONDONTWRITEBYTECODE": "1", **variables}
    return subprocess.run(
        ["/bin/sh", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=100
    )


def read_steps(project: Path, file: str = "robot.yml") -> list[dict[str, Any]]:
    jobs = yaml.safe_load((project / ".github" / "workflows" / file).read_text())["jobs"]
    return [step for job in jobs.values() for step in job["steps"]]


def list_problems(file: Path) -> list[tuple[str, str]]:
    cases = read_junit(file.read_bytes()).iter("testcase")
    return [(each.tag, each.attrib["type"]) for case in cases for each in case if "type" in each.attrib]


@pytest.mark.parametrize("template", [PROJECT, DRIVER, KIND], ids=lambda each: each.folder)
def test_every_new_project_has_both_workflows(template: Template, tmp_path: Path) -> None:
    make(template, tmp_path / "hauls")
    (workflow,) = (tmp_path / "hauls" / ".github" / "workflows").iterdir()
    github = [step["run"] for step in read_steps(tmp_path / "hauls", workflow.name) if "run" in step]
    gitlab = yaml.safe_load((tmp_path / "hauls" / ".gitlab-ci.yml").read_text())
    (job,) = gitlab.values()
    assert github[0] == job["script"][0]
    assert "install" in github[0]


def test_the_steps_are_the_checks_of_the_script(project: Path) -> None:
    script = (project / "ci.sh").read_text()
    checks = re.findall(r"^(\w+)\)", script, re.MULTILINE)
    assert [step["run"] for step in read_steps(project) if "run" in step] == [
        f"sh ci.sh {check}" for check in checks if check != "all"
    ]
    (loop,) = re.findall(r"for each in (.*); do", script)
    assert loop.split() == [check for check in checks if check not in ("install", "all")]


def test_a_check_runs_also_if_an_earlier_one_has_failed(project: Path) -> None:
    install, tests, *others = (step for step in read_steps(project) if "run" in step or "artifact" in step["uses"])
    assert install["id"] == "install"
    assert "if" not in tests
    assert {step["if"] for step in others} == {"${{ !cancelled() && steps.install.outcome == 'success' }}"}
    (job,) = yaml.safe_load((project / ".gitlab-ci.yml").read_text()).values()
    assert job["artifacts"]["when"] == "always"


def test_the_requirements_name_the_extras_of_the_checks_and_no_other_package(project: Path) -> None:
    lines = [line for line in (project / "requirements.txt").read_text().splitlines() if not line.startswith("#")]
    assert lines == ["robotcore[deploy,pi,record,sweep]>=0.1", "pytest>=8"]


@pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")
def test_git_keeps_the_recordings_of_the_check_only(project: Path) -> None:
    type_line(project, "git init -q")
    kept = ["recordings/seed-7.mcap", ".github/workflows/robot.yml", ".gitlab-ci.yml", "recordings/README.md"]
    ignored = ["run.mcap", "recordings/rover.local/run.mcap", "build/badge.svg", "sweeps/search-1/results.csv"]
    answer = type_line(project, f"git check-ignore {' '.join([*kept, *ignored])}").stdout
    assert answer.split() == ignored


@pytest.mark.slow
def test_all_checks_pass_and_leave_their_results(project: Path) -> None:
    ran = type_line(project, "sh ci.sh", SEEDS="1-3")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    names = {file.name for file in (project / "build" / "junit").iterdir()}
    assert names == {"tests.xml", "sweep.xml", "replay-new.xml"}
    for name in ("sweep.xml", "replay-new.xml"):
        assert list_problems(project / "build" / "junit" / name) == []
    cases = list(read_junit((project / "build" / "junit" / "sweep.xml").read_bytes()).iter("testcase"))
    assert len(cases) == 3 + 2, "the runs, and the two bounds"
    assert "passed: 100 % of 3 runs verified" in (project / "build" / "badge.svg").read_text()
    assert (project / "build" / "report" / "index.html").stat().st_size > 10_000
    results = [path.rstrip("/") for path in read_steps(project)[-1]["with"]["path"].split()]
    assert all((project / path).is_dir() for path in results)


@pytest.mark.slow
def test_a_wrong_app_fails_each_check_by_name(project: Path) -> None:
    app = project / "search.py"
    app.write_text(app.read_text().replace("< self.stop_distance_m", "< 2 * self.stop_distance_m"))
    ran = type_line(project, "sh ci.sh", SEEDS="1-2")
    assert ran.returncode == 1
    assert ran.stderr.endswith("These checks have failed: tests sweep\n")
    assert list_problems(project / "build" / "junit" / "sweep.xml") == [("failure", "disputed")] * 2 + [
        ("failure", "gate")
    ]
    assert "failed: 0 % of 2 runs verified" in (project / "build" / "badge.svg").read_text()


@pytest.mark.slow
def test_the_replay_fails_if_the_app_cannot_start_although_an_older_recording_is_there(project: Path) -> None:
    app = project / "search.py"
    assert type_line(project, "sh ci.sh replay").returncode == 0
    app.write_text("this is no Python")
    ran = type_line(project, "sh ci.sh replay")
    assert ran.returncode == 1
    assert "recorded nothing" in ran.stderr


@pytest.mark.slow
def test_the_replay_fails_if_the_app_uses_random_numbers(project: Path) -> None:
    app = project / "search.py"
    code = app.read_text().replace("2 * ball.bearing", "(2 + 0.1 * random()) * ball.bearing")
    app.write_text(code.replace("from math import tau\n", "from math import tau\nfrom random import random\n"))
    ran = type_line(project, "sh ci.sh replay")
    assert ran.returncode == 1
    assert ran.stderr.endswith("These replays have failed: build/new.mcap\n")
    assert list_problems(project / "build" / "junit" / "replay-new.xml") == [("failure", "deviation")]


@pytest.mark.slow
def test_a_kept_recording_fails_after_a_change_until_it_is_recorded_again(project: Path) -> None:
    assert RECORD in (project / "recordings" / "README.md").read_text()
    assert type_line(project, RECORD).returncode == 0
    app = project / "search.py"
    app.write_text(app.read_text().replace("2 * ball.bearing", "2.1 * ball.bearing"))
    ran = type_line(project, "sh ci.sh replay")
    assert ran.returncode == 1
    assert ran.stderr.endswith("These replays have failed: recordings/seed-7.mcap\n")
    assert list_problems(project / "build" / "junit" / "replay-kept-seed-7.xml") == [("failure", "deviation")]
    assert type_line(project, f"{RECORD} --force").returncode == 0
    assert type_line(project, "sh ci.sh replay").returncode == 0


@pytest.mark.slow
def test_a_kept_recording_fails_also_if_the_app_has_another_name_than_the_recorded_one(project: Path) -> None:
    assert type_line(project, RECORD).returncode == 0
    app = (project / "search.py").rename(project / "seek.py")
    app.write_text(app.read_text().replace("2 * ball.bearing", "2.1 * ball.bearing"))
    script = project / "ci.sh"
    script.write_text(script.read_text().replace("search.py", "seek.py"))
    ran = type_line(project, "sh ci.sh replay")
    assert ran.stderr.endswith("These replays have failed: recordings/seed-7.mcap\n")
    assert list_problems(project / "build" / "junit" / "replay-kept-seed-7.xml") == [("failure", "deviation")]


@pytest.mark.slow
def test_a_damaged_recording_fails_with_a_case(project: Path) -> None:
    (project / "recordings" / "broken.mcap").write_bytes(b"no recording")
    assert type_line(project, "sh ci.sh replay").returncode == 1
    assert list_problems(project / "build" / "junit" / "replay-kept-broken.xml") == [("error", "not-a-recording")]
    assert list_problems(project / "build" / "junit" / "replay-new.xml") == []


@pytest.mark.slow
def test_a_kept_recording_that_is_a_dangling_link_fails_and_the_case_of_a_deleted_one_is_removed(project: Path) -> None:
    (project / "recordings" / "lost.mcap").symlink_to("nowhere.mcap")
    stale = project / "build" / "junit" / "replay-kept-deleted.xml"
    stale.parent.mkdir(parents=True)
    stale.write_text("<testsuites/>")
    ran = type_line(project, "sh ci.sh replay")
    assert ran.stderr.endswith("These replays have failed: recordings/lost.mcap\n")
    assert not stale.exists()
    assert [tag for tag, _ in list_problems(stale.with_name("replay-kept-lost.xml"))] == ["error"]


def test_an_unknown_check_is_refused_with_the_names_of_all(project: Path) -> None:
    ran = type_line(project, "sh ci.sh swep")
    assert ran.returncode == 2
    assert "unknown check swep. Use install, tests, sweep or replay, or no argument for all" in ran.stderr
