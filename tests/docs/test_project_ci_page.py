from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml

from robotcore.cli.scaffold import PROJECT, make
from robotcore.junit import JUnitSuite
from robotcore.sweep.badge import build_badge_text, draw_badge
from robotcore.sweep.junit import build_suites
from robotcore.sweep.statistics import Requirement, group_records, wilson
from tests.docs.listings import CODE, list_listings, read_rows
from tests.robotcore.sweep.conftest import make_record
from tests.robotcore.sweep.test_junit import write_results

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "project-ci.md").read_text(encoding="utf-8")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    make(PROJECT, tmp_path / "hauls")
    return tmp_path / "hauls"


def test_the_table_has_the_checks_of_the_script_and_the_results_are_where_it_writes_them(project: Path) -> None:
    script = (project / "ci.sh").read_text()
    commands = [CODE.findall(row[0])[0] for row in read_rows(PAGE, "CI for your robot's project")]
    checks = [check for check in re.findall(r"^(\w+)\)", script, re.MULTILINE) if check != "all"]
    assert commands == [*(f"sh ci.sh {check}" for check in checks), "sh ci.sh"]
    named = set(re.findall(r"`(build/[\w./]+)`", PAGE)) - {"build/report/index.html"}
    assert [path for path in named if path not in script] == []


def test_the_bounds_and_the_rooms_are_those_of_the_script(project: Path) -> None:
    script = (project / "ci.sh").read_text()
    assert re.findall(r'--require "(.*?)"', script) == ["verified>=0.95", "contacts<=0"]
    assert "${SEEDS:-1-50}" in script
    low, _ = wilson(50, 50)
    assert f"begins at {100 * low:.1f} %" in " ".join(PAGE.split())


def test_the_command_that_keeps_a_recording_is_that_of_the_project(project: Path) -> None:
    commands = [line for each in list_listings(PAGE) for line in each.text.splitlines() if "recordings/" in line]
    readme = (project / "recordings" / "README.md").read_text()
    assert len(commands) == 2
    assert [line for line in commands if line.replace("my_robot", "hauls") not in readme] == []


def test_the_names_of_the_test_cases_are_those_of_a_sweep(tmp_path: Path) -> None:
    bound = Requirement.parse("verified>=0.95")
    (suite,) = build_suites(write_results(tmp_path, [make_record(seed=7, world="open")]), [bound], "")
    assert isinstance(suite, JUnitSuite)
    names = [CODE.findall(row[0])[0] for row in read_rows(PAGE, "JUnit files")]
    assert [case.name for case in suite.cases] == [name.replace("room", "open") for name in names[:2]]


def test_the_picture_is_a_badge_of_this_version() -> None:
    records = [make_record(seed=seed) for seed in range(50)]
    text = build_badge_text("search.py", group_records(records), [Requirement.parse("verified>=0.95")])
    content = (ROOT / "docs" / "images" / "badge.svg").read_bytes()
    assert content == draw_badge(text)
    assert f"![{text.label}, {text.message}]" in PAGE
    assert len(content) < 1100
    assert ET.fromstring(content).tag.endswith("svg")  # noqa: S314  the page's own


def read_step(name: str) -> dict[str, Any]:
    (listing,) = (each.text for each in list_listings(PAGE) if f"- name: {name}\n" in each.text)
    (step,) = yaml.safe_load(listing)
    assert isinstance(step, dict)
    return step


def test_the_reporter_reads_the_files_of_the_script() -> None:
    assert read_step("Show the tests")["with"]["report_paths"] == "build/junit/*.xml"


def test_gitlab_shows_its_own_badge_beside_that_of_the_sweep_because_an_artifact_is_of_a_job_that_passed() -> None:
    (listing,) = (each.text for each in list_listings(PAGE) if "/-/jobs/artifacts/" in each.text)
    assert "/badges/main/pipeline.svg" in listing


@pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")
def test_the_step_puts_the_badge_on_a_branch_of_its_own_again_and_again(project: Path, tmp_path: Path) -> None:
    def type_lines(lines: str, folder: Path) -> str:
        command = ["/bin/bash", "-e", "-c", lines]
        return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout

    author = "git -c user.name=a -c user.email=a@b.c"
    type_lines(f"git init -q -b main && git add . && {author} commit -qm Begin", project)
    type_lines("git clone -q --bare hauls origin.git", tmp_path)
    for number in ("1", "2"):
        clone = tmp_path / f"clone-{number}"
        type_lines(f"git clone -q origin.git {clone.name}", tmp_path)
        (clone / "build").mkdir()
        (clone / "build" / "badge.svg").write_text(number)
        type_lines(read_step("Badge")["run"], clone)
        origin = tmp_path / "origin.git"
        assert type_lines("git ls-tree -r --name-only badge", origin) == "build/badge.svg\n"
        assert type_lines("git show badge:build/badge.svg", origin) == number
        assert type_lines("git rev-list --count main", origin) == "1\n"
