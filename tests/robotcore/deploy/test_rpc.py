from __future__ import annotations

import ast
import json
import os
import re
import select
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from robotcore.deploy import rpc, rsync, ssh
from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.robot_answers import EmptyAnswer, ProgressMessage, RobotMessage
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError
from tests.robotcore.deploy.conftest import ECHO, WAIT, AddAction
from tests.robotcore.deploy.sshd import Sshd, serving, slow_rsync
from tests.texts import Raises

NASTY = {"a b": 'it\'s "so" $(touch canary) `x` \\ \n \0 ü \udcff \U0001f916', "n": [1, 2.5, None, True]}


def answers(script: str, folder: Path) -> list[dict[str, Any]]:
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-"], input=script.encode("ascii"), capture_output=True, cwd=folder, check=False
    )
    assert done.stderr == b""
    return [json.loads(line) for line in done.stdout.decode().split(MARK)[1:]]


def test_call_needs_only_the_standard_library_on_the_robot(add_action: AddAction, tmp_path: Path) -> None:
    add_action("echo", ECHO)
    begun, done = answers(rpc.build_script("echo", NASTY), tmp_path)
    assert begun == {"begun": "echo"}
    assert done == {"done": {"arguments": NASTY}}
    assert not list(tmp_path.iterdir())


def test_old_python_refuses_the_call(tmp_path: Path) -> None:
    script = rpc.build_script("probe", {}).replace("MIN_PYTHON = (3, 10)", "MIN_PYTHON = (9, 0)")
    _, refused = answers(script, tmp_path)
    version = sys.version.split()[0]
    assert refused["refused"]["problem"] == f"its Python is {version}, robotcore needs 9.0 or newer"
    assert refused["refused"]["kind"] == "python"


def test_bootstrap_has_no_new_syntax() -> None:
    with pytest.raises(SyntaxError):
        ast.parse("(a := 1)", feature_version=(3, 7))
    ast.parse(rpc.build_script("probe", {}), feature_version=(3, 7))


GONE_S = 10

LONG = 12 << 20

PRINT_LINE = """
def act(layout):
    print("a line of a log")
    return {}
"""


class Echo(RobotMessage):
    arguments: dict[str, Any]


NAMES = (
    "with space.txt",
    "$(touch canary)",
    "`touch canary`",
    "; touch canary",
    "| touch canary",
    "> canary",
    "'; touch canary; '",
    '"; touch canary; "',
    "new\nline; touch canary",
    "\\",
    "-e touch canary",
    "--rsync-path=touch canary",
    "*",
    "[a-z]",
    "{a,b}",
    "~root",
    "#comment",
    "!history",
    "${HOME}",
    "%n",
    "rover:file",
    "::module",
    "\x1e{'done': 1}",
    "\x1b[31mred",
    "\U0001f916",
    os.fsdecode(b"not-utf8-\xff\xfe"),
    "trailing ",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of files with difficult names."""
    folder = tmp_path / 'it\'s "to" $(touch canary): send'
    for name in NAMES:
        (folder / "project" / name).mkdir(parents=True)
        (folder / "project" / name / name).write_bytes(os.fsencode(name))
    return folder


def read_contents(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_files_of_any_name_arrive_and_no_shell_runs_them(
    link: RobotLink, robot: Sshd, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RSYNC_CHECKSUM_LIST", "of a user's own")
    (robot.home / "robotcore" / "incoming" / "new" / "of a broken push").mkdir()
    transfer = rsync.send(link, folder, "incoming/new")
    assert not (robot.home / "robotcore" / "incoming" / "new" / "of a broken push").exists()
    assert read_contents(robot.home / "robotcore" / "incoming" / "new") == read_contents(folder)
    assert transfer.files == transfer.changed == len(NAMES)
    assert not list(folder.parent.rglob("canary"))


def test_equal_files_with_other_times_are_copied_on_the_robot(link: RobotLink, robot: Sshd, folder: Path) -> None:
    root = robot.home / "robotcore"
    first = rsync.send(link, folder, "incoming/new")
    (root / "incoming" / "new").rename(root / "current")
    (root / "incoming" / "newer").mkdir()
    for file in folder.rglob("*"):
        os.utime(file, (0, 0))
    changed = folder / "project" / "with space.txt" / "with space.txt"
    changed.write_bytes(b"WITH SPACE.TXT")  # of the same length
    os.utime(changed, (0, 0))
    second = rsync.send(link, folder, "incoming/newer", "current")
    assert read_contents(root / "incoming" / "newer") == read_contents(folder)
    assert read_contents(root / "current") != read_contents(folder)
    assert (second.files, second.changed) == (len(NAMES), 1)
    assert second.sent < first.sent


@pytest.mark.slow
def test_next_transfer_resumes_an_incomplete_recording(
    link: RobotLink, robot: Sshd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = robot.home / "robotcore" / "recordings" / "long.mcap"
    home, partial = tmp_path / "at home: $(touch canary)", tmp_path / "partial"
    recording.write_bytes(os.urandom(LONG))
    home.mkdir()

    def interrupt(done: int, part: float) -> None:
        if done:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setenv("PATH", str(slow_rsync(tmp_path / "slow")), prepend=os.pathsep)
        with pytest.raises(KeyboardInterrupt):
            rsync.receive(link, [recording.name], home, partial=partial, on_progress=interrupt)
    assert not (home / recording.name).exists()
    transfer = rsync.receive(link, [recording.name], home, partial=partial)
    assert transfer.received < LONG
    assert [(file.name, file.stat().st_size) for file in home.iterdir()] == [(recording.name, LONG)]
    assert recording.exists()
    assert not list(tmp_path.rglob("canary"))


def test_only_recordings_are_received(link: RobotLink, tmp_path: Path) -> None:
    for name in [*NAMES, "", "a.mcap\n", "..", "../a.mcap", "/etc/a.mcap", "a\0.mcap", f"{'a' * 96}.mcap", "ü.mcap"]:
        with pytest.raises(ValueError, match=re.escape(repr(name))):
            pytest.fail(f"{name!r} is received: {rsync.receive(link, [name], tmp_path, partial=tmp_path)}")


def test_files_are_sent_into_the_robots_folder_only(link: RobotLink, folder: Path) -> None:
    for to in ("", "..", "/etc", "incoming/../../.ssh", "a b", "$(touch canary)", "-x", "~", "incoming/new\n"):
        with pytest.raises(ValueError, match=re.escape(repr(to))):
            rsync.send(link, folder, to)


def test_interrupted_call_ends_on_the_robot_and_the_link_still_works(link: RobotLink, add_action: AddAction) -> None:
    add_action("wait", WAIT)
    add_action("echo", ECHO)
    waiting: list[int] = []

    def interrupt(message: ProgressMessage) -> None:
        waiting.extend(os.pidfd_open(int(pid)) for pid in message.text.split())
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        link.call("wait", EmptyAnswer, on_message=interrupt)
    for process in waiting:
        assert select.select([process], [], [], GONE_S)[0]
        os.close(process)
    assert link.call("echo", Echo, a=1) == Echo(arguments={"a": 1})


def test_closed_link_leaves_no_process_and_no_file(sshd: Sshd, monkeypatch: pytest.MonkeyPatch) -> None:
    with TemporaryDirectory(dir=ssh.SOCKET_FOLDER) as room:
        monkeypatch.setattr(ssh, "SOCKET_FOLDER", room)
        with RobotLink(sshd.address):
            [process] = map(os.pidfd_open, sshd.connections())
            assert list(Path(room).iterdir())
        assert select.select([process], [], [], GONE_S)[0]
        os.close(process)
        assert not list(Path(room).iterdir())


def test_login_shell_that_prints_disturbs_transfers_but_no_calls(
    tmp_path: Path, add_action: AddAction, raises: Raises
) -> None:
    add_action("print_line", PRINT_LINE)
    shell = "echo Welcome; printf '$ '; echo oops >&2; eval \"$SSH_ORIGINAL_COMMAND\""
    with (
        serving(tmp_path / "sshd", f"ForceCommand {shell}") as sshd,
        RobotLink(sshd.address) as link,
    ):
        lines: list[str] = []
        link.stream("print_line", lines.append, max_bytes=None)
        assert lines == ["a line of a log"]
        (sshd.home / "robotcore" / "new").mkdir(parents=True)
        with raises(DeployError, "unclean-shell"):
            rsync.send(link, sshd.bin, "new")


def test_ssh_configuration_of_the_user_for_logins_does_no_harm(sshd: Sshd, add_action: AddAction) -> None:
    add_action("echo", ECHO)
    own = (
        "RemoteCommand echo no",
        "RequestTTY force",
        f"LocalForward 127.0.0.1:{sshd.port} localhost:1",
        "ControlPersist 600",
    )
    sshd.config.write_text("\n".join((*own, "ExitOnForwardFailure yes", sshd.config.read_text())))
    with RobotLink(sshd.address) as link:
        assert link.call("echo", Echo, a=1) == Echo(arguments={"a": 1})
