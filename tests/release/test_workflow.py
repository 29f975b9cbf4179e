"""The workflow of a release runs commands of this repository, with no more rights than each job needs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).parents[2]
FILE = ROOT / ".github" / "workflows" / "release.yml"


@pytest.fixture(scope="module")
def workflow() -> Any:
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))


def test_a_tag_of_a_version_starts_it(workflow: Any) -> None:
    assert workflow[True] == {"push": {"tags": ["v*"]}}  # YAML reads the key `on` as a boolean


def test_no_job_that_runs_the_code_may_write_and_the_job_that_publishes_may_not_change_the_repository(
    workflow: Any,
) -> None:
    assert workflow["permissions"] == {}
    assert {name: job["permissions"] for name, job in workflow["jobs"].items()} == {
        "build": {"contents": "read"},
        "test": {"contents": "read"},
        "draft": {"contents": "write"},
        "publish": {"attestations": "write", "id-token": "write"},
        "release": {"contents": "write"},
    }
    assert workflow["jobs"]["publish"]["environment"] == "release"


def test_the_release_is_a_draft_until_the_files_are_published(workflow: Any) -> None:
    needs = {name: job.get("needs") for name, job in workflow["jobs"].items()}
    assert needs == {
        "build": None,
        "test": "build",
        "draft": ["build", "test"],
        "publish": "draft",
        "release": "publish",
    }


def test_every_action_is_pinned_to_a_commit_with_its_tag() -> None:
    lines = [line.strip() for line in FILE.read_text(encoding="utf-8").splitlines() if "uses:" in line]
    assert len(lines) >= 10
    assert [line for line in lines if not re.search(r"uses: [\w/-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+$", line)] == []


def run_step(workflow: Any, job: str, start: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a step of a job as the server does."""
    (step,) = (each for each in workflow["jobs"][job]["steps"] if each.get("name", "").startswith(start))
    return subprocess.run(
        ["/bin/bash", "-e", "-o", "pipefail", "-c", step["run"]],
        cwd=folder,
        env={**os.environ, "GITHUB_REF_NAME": "v1.2.3", **variables},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.posix("the server's shell")
@pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")
def test_a_tag_of_a_commit_that_is_not_on_main_is_refused(workflow: Any, tmp_path: Path) -> None:
    checkout = workflow["jobs"]["build"]["steps"][0]
    assert checkout["with"]["fetch-depth"] == 0, "without the history, git knows no ancestor"
    commit = "git -c user.name=a -c user.email=a@b.c commit -q --allow-empty -m"
    lines = f"""git init -q -b main origin && cd origin && {commit} first && git tag on-main && {commit} second
        git checkout -q -b other && {commit} third && cd .. && git clone -q origin clone"""
    subprocess.run(["/bin/bash", "-e", "-c", lines], cwd=tmp_path, check=True)
    for branch, status in (("on-main", 0), ("origin/main", 0), ("origin/other", 1)):
        subprocess.run(["/bin/bash", "-c", f"git checkout -q {branch}"], cwd=tmp_path / "clone", check=True)
        ran = run_step(workflow, "build", "Check that the commit", tmp_path / "clone")
        assert (ran.returncode, "v1.2.3 is not on main" in ran.stderr) == (status, status == 1), branch


@pytest.fixture
def gh(tmp_path: Path) -> Path:
    """Make a folder with the files of a release, and a program ``gh`` that notes its calls in ``calls``."""
    (tmp_path / "dist").mkdir()
    (tmp_path / "dist" / "robotcore.whl").touch()
    program = tmp_path / "gh"
    program.write_text(
        '#!/bin/sh\necho "$*" >> calls\n[ "$2" != view ] || { [ -n "$IS_DRAFT" ] && echo "$IS_DRAFT"; }\n'
    )
    program.chmod(0o755)
    return tmp_path


@pytest.mark.posix("the server's shell")
@pytest.mark.parametrize(
    "is_draft, status, calls",
    [("", 0, ["view", "create", "upload"]), ("true", 0, ["view", "edit", "upload"]), ("false", 1, ["view"])],
    ids=["new", "again", "public"],
)
def test_the_draft_can_be_made_again_and_a_public_release_keeps_its_files(
    workflow: Any, gh: Path, is_draft: str, status: int, calls: list[str]
) -> None:
    ran = run_step(workflow, "draft", "Make a draft", gh, PATH=f"{gh}:{os.environ['PATH']}", IS_DRAFT=is_draft)
    made = (gh / "calls").read_text().splitlines()
    assert (ran.returncode, [line.split()[1] for line in made]) == (status, calls), ran.stderr
    assert all("--draft" in line and "--verify-tag" in line for line in made if " create " in line)
    assert all(line == "release upload v1.2.3 dist/robotcore.whl --clobber" for line in made if " upload " in line)


@pytest.mark.posix("the server's shell")
@pytest.mark.parametrize("tag, kind", [("v1.2.3", "--latest"), ("v1.2.3rc1", "--prerelease")])
def test_the_last_job_makes_the_draft_public(workflow: Any, gh: Path, tag: str, kind: str) -> None:
    ran = run_step(workflow, "release", "Make", gh, PATH=f"{gh}:{os.environ['PATH']}", GITHUB_REF_NAME=tag)
    assert ran.returncode == 0
    assert (gh / "calls").read_text() == f"release edit {tag} --draft=false {kind}\n"


def test_its_commands_exist() -> None:
    text = FILE.read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    called = [target for line in re.findall(r"\bmake ([a-z -]+)$", text, re.MULTILINE) for target in line.split()]
    assert {"lint", "package", "system-package"} <= set(called)
    for target in called:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    for module in re.findall(r"python -m (release\S*)", text):
        assert Path(ROOT, *module.split(".")).with_suffix(".py").is_file()


def test_it_names_no_host() -> None:
    assert not re.search(r"https?://|\w\.(org|com|io)\b", FILE.read_text(encoding="utf-8"))
