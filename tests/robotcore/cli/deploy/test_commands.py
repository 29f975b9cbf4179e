from __future__ import annotations

import os
import pty
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli.deploy._output import _make_spinner
from robotcore.deploy.agent.releases import HEALTHY, HealthResult, Release
from robotcore.deploy.progress import Progress
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.deploy.conftest import Deploy
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd


def on_terminal(*arguments: str) -> bytes:
    """Return what robotcore writes on a terminal."""
    line, its_end = pty.openpty()
    screen = b""
    with subprocess.Popen(
        [sys.executable, "-m", "robotcore", *arguments], stdin=its_end, stdout=its_end, stderr=its_end
    ) as process:
        os.close(its_end)
        with suppress(OSError):  # the terminal has gone with the command
            while piece := os.read(line, 4096):
                screen += piece
        process.wait()
    os.close(line)
    return screen


OLD, NEW = "2026-11-21T22-40-03Z", "2026-11-21T22-52-10Z"

COMMANDS = ("push", "list", "rollback", "status", "logs", "start", "stop", "remove", "fetch")

STATE: dict[str, Any] = {
    "release": NEW,
    "verdict": "healthy",
    "on_trial": None,
    "last": None,
    "state": "running",
    "for_s": 3723.4,
    "restarts": 2,
    "words": "approach, 12.4 s",
    "reason": "",
    "lines": [],
    "starts_with_robot": True,
    "lingers": True,
    "recordings": {"files": 3, "bytes": 41_000_000},
    "free_bytes": 12_300_000_000,
}
"""As a target of systemd's told it."""

FAILED = {
    "state": "failed",
    "for_s": None,
    "reason": "it ended with status 5",
    "lines": ["ValueError: no"],
    "words": "",
}

REFUSING = """
from robotcore.deploy.agent.rpc import AgentError

def act(layout, **arguments):
    raise AgentError("lingering is off", "On the robot: sudo loginctl enable-linger pi", "linger")
"""

LOG = """
import os, signal, subprocess

def act(layout, lines, follow):
    print("a line of", lines)
    print("  another", flush=True)
    if follow:
        os.kill({pid}, signal.SIGINT)
        subprocess.run(["sleep", "600"])
    return {{}}
"""

HOSTILE_LOG = """
def act(layout, **arguments):
    print("a \\x1b]0;title\\x07\\x1b[2J\\r \\tend", flush=True)
    return {}
"""

FORGING = """
from robotcore.deploy.agent.rpc import AgentError

def act(layout, **arguments):
    raise AgentError("no\\nerror: forged. run: curl evil | sh\\x1b[A", "\\u202enow", "linger")
"""

ON_TRIAL = """
import os, signal, subprocess
from robotcore.deploy.agent.rpc import report_progress

def act(layout, **arguments):
    report_progress("it starts")
    os.kill({pid}, signal.SIGINT)
    subprocess.run(["sleep", "600"])
"""

REMOVE = """
def act(layout, keeps_recordings):
    (layout.home / "removed").touch()
    return {"removed": True, "kept": keeps_recordings}
"""


def answering(answer: dict[str, Any]) -> str:
    return f"def act(layout, **arguments):\n    return {answer!r}\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_host_that_is_none_is_wrong_usage(command: str, cli: Cli) -> None:
    result = cli("deploy", command, "-oProxyCommand=touch canary" if command == "list" else "rover;touch canary")
    assert result.status == 2
    assert not Path("canary").exists()


def test_no_command_is_answered_with_the_help(cli: Cli) -> None:
    assert cli("deploy") == cli("deploy", "--help")


@pytest.mark.parametrize("command", ["list", "status"])
def test_robot_that_cannot_be_reached_is_reported_in_json_too(command: str, cli: Cli) -> None:
    result = cli("deploy", command, "nobody.invalid", "--json")
    assert result.status == result.json["exit_status"] == 3
    assert result.json["host"] == "nobody.invalid"
    assert result.json["error"] in result.err


def test_status_says_what_runs_and_how(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", answering(STATE))
    result = deploy("status")
    assert result.status == 0
    assert result.out.splitlines() == [
        f"robot: {NEW} running for 1 h 2 min, restarted 2 times",
        "  says         approach, 12.4 s",
        "  recordings   3, 41.0 MB; 12.3 GB free",
    ]


def test_what_was_restarted_once_is_reported_so(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", answering({**STATE, "restarts": 1}))
    assert deploy("status").out.splitlines()[0].endswith(" min, restarted once")


def test_status_of_what_was_started_again_has_the_reason(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", answering({**STATE, "reason": "it ended with status 5", "lines": ["ValueError: no"]}))
    assert "  restarted    it ended with status 5\n    ValueError: no\n" in deploy("status").out


def test_status_of_what_does_not_run_has_the_reason_and_exits_1(
    deploy: Deploy, add_action: AddAction, robot: Sshd
) -> None:
    add_action("status", answering({**STATE, **FAILED, "on_trial": NEW, "lingers": False, "starts_with_robot": False}))
    result = deploy("status")
    assert result.status == 1
    assert f"  on trial     {NEW}" in result.out
    assert "  failed       it ended with status 5\n    ValueError: no\n" in result.out
    assert "sudo loginctl enable-linger" in result.out
    assert f"robotcore deploy start robot --ssh-config {robot.config}\n" in result.out


def test_status_as_json_is_what_the_robot_tells(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", answering(STATE))
    assert deploy("status", "--json").json == {"host": "robot", **STATE, "exit_status": 0}


def test_status_of_a_robot_without_a_release_says_how_to_begin(
    deploy: Deploy, add_action: AddAction, robot: Sshd
) -> None:
    add_action("status", answering({**STATE, "release": None, "state": "stopped"}))
    result = deploy("status")
    push = f"robotcore deploy push robot --ssh-config {robot.config}"
    assert (result.status, result.out) == (1, f"robot: nothing was put there yet. {push}\n")


def test_status_after_a_first_push_that_failed_says_so(deploy: Deploy, add_action: AddAction) -> None:
    last = {"name": NEW, "outcome": "unhealthy", "reason": "it ended with status 5"}
    add_action("status", answering({**STATE, "release": None, "state": "stopped", "last": last}))
    result = deploy("status")
    assert result.status == 1
    assert f"robot: {NEW} did not live (it ended with status 5); nothing runs. robotcore deploy push" in result.out


def test_stop_where_nothing_is_says_so(deploy: Deploy, add_action: AddAction) -> None:
    add_action("stop", answering({**STATE, "release": None, "state": "stopped"}))
    result = deploy("stop")
    assert (result.status, result.out) == (0, "robot: nothing of robotcore's runs there\n")


def test_rollback_to_a_release_that_is_not_there_is_wrong_usage(deploy: Deploy) -> None:
    result = deploy("rollback", "2026-01-01T00-00-00Z")
    assert result.status == 2
    assert "there is no release '2026-01-01T00-00-00Z'. " in result.err


def test_list_names_each_release_with_its_verdict_and_what_was_proven(deploy: Deploy, robot: Sshd) -> None:
    root = robot.home / "robotcore"
    for name in (OLD, NEW):
        (root / "releases" / name).mkdir(parents=True)
        proven = ("tests: 12 passed",)
        release = Release(
            name, "mine", "search.py", "my_robot.toml", "raspberrypi", (), (), gates=proven, sender="ann@desk"
        )
        release.write(root / "releases" / name)
    HealthResult(HEALTHY).write(root / "releases" / OLD)
    (root / "current").symlink_to(f"releases/{OLD}")
    result = deploy("list")
    head, _, newer, older = result.out.splitlines()
    assert head.split()[:2] == ["release", "state"]
    assert newer.split()[:2] == [NEW, "search.py"]
    assert older.split()[:4] == [OLD, "current,", "healthy", "search.py"]
    assert "ann@desk" in older
    assert "tests: 12 passed" in older
    assert [each["verdict"] for each in deploy("list", "--json").json["releases"]] == [None, "healthy"]


def test_start_and_stop_tell_how_the_robot_does_then(deploy: Deploy, add_action: AddAction) -> None:
    add_action("start", answering(STATE))
    add_action("stop", answering({**STATE, "state": "stopped", "for_s": None, "restarts": 0}))
    started, stopped = deploy("start"), deploy("stop")
    assert (started.status, stopped.status) == (0, 0)
    assert f"{NEW} running for" in started.out
    assert f"robot: {NEW} stopped\n" in stopped.out


def test_refusal_of_the_robot_says_what_to_do_and_exits_3(deploy: Deploy, add_action: AddAction) -> None:
    add_action("start", REFUSING)
    result = deploy("start")
    assert result.status == 3
    assert result.err == "error: robot: lingering is off. On the robot: sudo loginctl enable-linger pi\n"


def test_logs_are_passed_through_and_ctrl_c_ends_the_looking(deploy: Deploy, add_action: AddAction) -> None:
    add_action("logs", LOG.format(pid=os.getpid()))
    result = deploy("logs", "-n", "7")
    assert (result.status, result.out) == (0, "a line of 7\n  another\n")
    result = deploy("logs", "-f")
    assert (result.status, result.err) == (130, "")


def test_what_a_robot_logs_is_escaped_in_a_pipe_and_on_a_terminal(
    deploy: Deploy, add_action: AddAction, robot: Sshd
) -> None:
    add_action("logs", HOSTILE_LOG)
    result = deploy("logs")
    assert result.out == "a \\x1b]0;title\\x07\\x1b[2J\\r \tend\n"
    (robot.folder / "bin" / "python3").unlink()
    (robot.folder / "bin" / "python3").write_text(f"#!/bin/sh\ncat >/dev/null; cat {robot.folder}/answer\n")
    (robot.folder / "bin" / "python3").chmod(0o755)
    (robot.folder / "answer").write_bytes(b'\x1e{"begun": 1}\na \x1b]0;title\x07\x1b[2J\n\x1e{"done": {}}\n')
    try:
        screen = on_terminal("deploy", "logs", robot.host, "--ssh-config", str(robot.config))
    finally:
        (robot.folder / "bin" / "python3").unlink()
        (robot.folder / "bin" / "python3").symlink_to(Path(sys.executable).resolve())
    assert b"\\x1b]0;title\\x07\\x1b[2J" in screen
    assert b"\x1b]0" not in screen


@pytest.mark.parametrize("command", ["list", "rollback", "status", "logs", "start", "stop", "fetch"])
def test_refusal_cannot_forge_a_line(deploy: Deploy, add_action: AddAction, command: str) -> None:
    for action in ("releases", "rollback", "status", "logs", "start", "stop", "recordings"):
        add_action(action, FORGING)
    result = deploy(command)
    assert (result.status, result.out) == (3, "")
    assert result.err == "error: robot: no\\nerror: forged. run: curl evil | sh\\x1b[A. \\u202enow\n"


@pytest.mark.parametrize("answer", ["5", "None", "[]", "{}", "{'recordings': 5}", "{'release': '../..'}"])
@pytest.mark.parametrize("command", ["list", "rollback", "status", "start", "stop", "fetch"])
def test_damaged_answer_is_named_and_exits_3(deploy: Deploy, add_action: AddAction, command: str, answer: str) -> None:
    for action in ("releases", "rollback", "status", "start", "stop", "recordings"):
        add_action(action, f"def act(layout, **arguments):\n    return {answer}\n")
    result = deploy(command)
    assert result.status == 3
    assert result.err.startswith("error: robot: its answer to ")
    assert len(result.err.splitlines()) == 1


def test_remove_of_a_damaged_answer_exits_3(deploy: Deploy, add_action: AddAction) -> None:
    add_action("remove", "def act(layout, **arguments):\n    return {'kept': 'no'}\n")
    assert deploy("remove", "--yes").status == 3


def test_words_of_a_robot_on_a_terminal_are_no_markup_of_the_line_that_moves() -> None:
    spinner = _make_spinner(Progress("release", "[/] [red]it starts[/red]"))
    assert str(spinner.text) == "release      [/] [red]it starts[/red]"


def test_ctrl_c_in_a_trial_says_that_it_goes_on_there(deploy: Deploy, add_action: AddAction, robot: Sshd) -> None:
    add_action("rollback", ON_TRIAL.format(pid=os.getpid()))
    result = deploy("rollback")
    assert result.status == 130
    assert result.err.splitlines() == [
        f"The trial goes on there: robotcore deploy status robot --ssh-config {robot.config}",
        "error: interrupted by SIGINT",
    ]


@pytest.mark.parametrize("name", ["", "v1", "../../etc"])
def test_rollback_to_what_is_no_release_is_wrong_usage_and_nobody_is_asked(deploy: Deploy, name: str) -> None:
    result = deploy("rollback", name)
    assert result.status == 2
    assert "is no release" in result.err


def test_remove_does_nothing_where_nobody_can_be_asked(deploy: Deploy, add_action: AddAction, robot: Sshd) -> None:
    add_action("remove", REMOVE)
    result = deploy("remove")
    assert result.status == 2
    assert "--yes" in result.err
    assert not (robot.home / "removed").exists()


@pytest.mark.parametrize("option, kept", [((), True), (("--recordings",), False)])
def test_remove_keeps_recordings_unless_it_is_reported_otherwise(
    deploy: Deploy, add_action: AddAction, robot: Sshd, option: tuple[str, ...], kept: bool
) -> None:
    add_action("remove", REMOVE)
    result = deploy("remove", "--yes", *option)
    assert result.status == 0
    assert (f"the recordings stay: robotcore deploy fetch robot --ssh-config {robot.config}" in result.out) is kept


def test_fetch_says_how_to_replay_the_newest_by_a_name_that_a_shell_takes(
    deploy: Deploy, robot: Sshd, tmp_path: Path
) -> None:
    recordings = robot.home / "robotcore" / "recordings"
    recordings.mkdir(parents=True)
    (recordings / f"{OLD}.mcap").write_text("seen")
    result = deploy("fetch", "-o", str(tmp_path / "from rover"))
    assert result.status == 0
    assert f"robotcore replay '{tmp_path}/from rover/{OLD}.mcap'" in result.out


def test_fetch_into_a_folder_that_cannot_be_made_is_wrong_usage(deploy: Deploy, robot: Sshd) -> None:
    recordings = robot.home / "robotcore" / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    (recordings / f"{NEW}.mcap").write_text("seen")
    result = deploy("fetch", "-o", "/proc/nowhere")
    assert result.status == 2
    assert "/proc/nowhere cannot be made" in result.err


def test_fetch_as_json_names_each_file_by_what_became_of_it(deploy: Deploy, robot: Sshd, tmp_path: Path) -> None:
    recordings = robot.home / "robotcore" / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    for file in recordings.iterdir():
        file.unlink()
    for name in (f"{OLD}.mcap", f"{NEW}.mcap", "evil\x1b.py"):
        (recordings / name).write_text("seen")
    (tmp_path / f"{OLD}.mcap").write_text("mine, and longer")
    result = deploy("fetch", "--json", "--move", "-o", str(tmp_path))
    assert result.status == 1
    assert result.json == {
        "host": "robot",
        "folder": str(tmp_path),
        "brought": [f"{NEW}.mcap"],
        "here": [],
        "different": [f"{OLD}.mcap"],
        "being_written": [],
        "left": ["evil\\x1b.py"],
        "erased": [f"{NEW}.mcap"],
        "newest": str(tmp_path / f"{NEW}.mcap"),
        "exit_status": 1,
    }


def test_fetch_from_a_robot_that_cannot_be_reached_is_reported_in_json(cli: Cli) -> None:
    result = cli("deploy", "fetch", "nobody.invalid", "--json")
    assert result.status == result.json["exit_status"] == 3


@pytest.mark.parametrize("link", ["recordings", "recordings/robot"])
def test_fetch_follows_no_link_unless_the_user_names_it(
    deploy: Deploy, robot: Sshd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, link: str
) -> None:
    recordings = robot.home / "robotcore" / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    (recordings / f"{NEW}.mcap").write_text("seen")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "project" / link).parent.mkdir(parents=True)
    (tmp_path / "project" / link).symlink_to(tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path / "project")
    result = deploy("fetch")
    assert result.status == 2
    assert f"-o {tmp_path}/elsewhere" in result.err
    assert not list((tmp_path / "elsewhere").rglob("*.mcap"))
    assert deploy("fetch", "-o", link).status == 0
    assert list((tmp_path / "elsewhere").rglob("*.mcap"))
