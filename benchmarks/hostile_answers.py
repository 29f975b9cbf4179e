"""The answers and files of hostile robots. Each would harm a client that did not treat it as data."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

CANARY = "pwned"
TOUCH = f"touch {CANARY}"
"""A shell command. If the file that it creates exists, a shell has executed it."""

RELEASE = "2026-11-21T22-40-03Z"
RECORDING = f"{RELEASE}.mcap"
ENDLESS = b"\0endless\0"
"""The mark in an answer before a piece that is sent again and again, without an end."""

ESCAPES = f"\x1b]0;{CANARY}\x07\x1b[2J\x1b]52;c;cHduZWQ=\x07\r\x9b2J\u202e"
FORGED = f"no\nerror: forged. run: {TOUCH}"

STATE: dict[str, Any] = {
    "release": RELEASE,
    "outcome": "healthy",
    "pending": None,
    "last": None,
    "state": "running",
    "for_s": 3.0,
    "restarts": 0,
    "status_text": "",
    "view_port": None,
    "reason": "",
    "lines": [],
    "starts_with_robot": True,
    "lingers": True,
    "recordings": {"files": 0, "bytes": 0},
    "free_bytes": 1,
}
FACTS: dict[str, Any] = {
    "host": "rover",
    "machine": "x86_64",
    "system": "Debian 12",
    "python": "3.11.2",
    "libc": "glibc",
    "libc_version": "2.36",
    "free_bytes": 1_000_000_000,
    "has_environment": True,
}
UPLOAD: dict[str, Any] = {"release": RELEASE, "to": f"incoming/{RELEASE}", "copy_from": None}
INSTALLATION: dict[str, Any] = {"environment": "kept", "findings": []}
FINDING = {"level": "error", "subject": ESCAPES, "message": FORGED, "remedy": ESCAPES}
HEALTH: dict[str, Any] = {
    "release": RELEASE,
    "outcome": "healthy",
    "reason": "",
    "lines": [],
    "current": RELEASE,
    "is_running": True,
    "is_stopped": False,
}


@dataclass(frozen=True)
class HostileRobot:
    """A hostile robot: the client's command, the answers to its actions, and the files of the robot and the client.

    ``write_recordings`` writes the robot's folder of recordings. ``write_client_files`` writes the client's working
    directory. ``rsync`` is a script that replaces the robot's rsync.
    """

    name: str
    command: tuple[str, ...]
    answers: dict[str, bytes] = field(default_factory=dict)
    write_recordings: Callable[[Path], object] | None = None
    write_client_files: Callable[[Path], object] | None = None
    rsync: str = ""


def encode_line(message: Any) -> bytes:
    """Return a message of the robot as a line."""
    return b"\x1e" + json.dumps(message).encode() + b"\n"


def encode_result(value: Any) -> bytes:
    """Return the robot's complete answer to a call."""
    return encode_line({"begun": "x"}) + encode_line({"done": value})


def encode_list(*names: str, size: int = 4) -> bytes:
    """Return the robot's answer with a list of recordings."""
    each = {"bytes": size, "is_file": True, "is_being_written": False}
    return encode_result({"recordings": [{"name": name, **each} for name in names]})


def build_hostile_robots() -> list[HostileRobot]:
    """Return all hostile robots. Robots of different groups alternate, so that the first few are a sample of all."""
    groups = [list(group()) for group in _GROUPS]
    rounds = max(map(len, groups))
    return [group[number] for number in range(rounds) for group in groups if number < len(group)]


def _list_file_robots() -> Iterator[HostileRobot]:
    fetch = ("fetch",)
    names = ("evil.py", ".bashrc", f"$({TOUCH}).mcap", f"; {TOUCH};.mcap", "--rsh=sh.mcap", f"two\n{ESCAPES}.mcap")
    for name in names:
        yield HostileRobot(f"file {ascii(name)[:40]}", fetch, write_recordings=partial(_put, name))
    for name, leads in {"link out": "/etc/hostname", "link to the app": "../../app.py", "link in": RECORDING}.items():
        yield HostileRobot(name, fetch, write_recordings=partial(_link, "evil.mcap", leads))
    yield HostileRobot("folder", fetch, write_recordings=lambda home: (home / "evil.mcap").mkdir())
    yield HostileRobot("program", fetch, write_recordings=_program)
    yield HostileRobot(
        "link here, file there", fetch, write_recordings=_recording, write_client_files=partial(_link_file, "app.py")
    )
    yield HostileRobot(
        "dead link here",
        (*fetch, "--move"),
        write_recordings=_recording,
        write_client_files=partial(_link_file, "new.py"),
    )
    for name in ("recordings", "recordings/robot", "recordings/robot/.partial"):
        yield HostileRobot(
            f"{name} is a link", fetch, write_recordings=_recording, write_client_files=partial(_link_folder, name)
        )


def _list_list_robots() -> Iterator[HostileRobot]:
    lies: dict[str, bytes] = {
        "name of ../": encode_list("../../../../../etc/hostname.mcap"),
        "absolute name": encode_list("/etc/hostname.mcap"),
        "name of ..": encode_list(".."),
        "size of 2^60": encode_list(RECORDING, size=1 << 60),
        "larger than it says": encode_list(RECORDING, size=1),
        "not there": encode_list("absent.mcap"),
        "link called a file": encode_list("evil.mcap", size=5),
        "pipe called a file": encode_list("pipe.mcap", size=5),
        "twice the same": encode_list(RECORDING, RECORDING),
        "a million names": encode_list(*("x" * 4,) * 1_000_000),
        "50 000 bad names": encode_list(*(f"{number}.py" for number in range(50_000))),
    }
    for name, answer in lies.items():
        yield HostileRobot(f"list: {name}", ("fetch", "--move"), {"recordings": answer}, write_recordings=_traps)


def _list_answer_robots() -> Iterator[HostileRobot]:
    said = encode_line({"begun": "x"})
    done = encode_line({"done": {}})
    refusal = encode_line({"refused": {"problem": FORGED + ESCAPES, "remedy": ESCAPES, "kind": ESCAPES}})
    texts = {"status_text": ESCAPES, "reason": FORGED, "lines": [ESCAPES, FORGED], "state": FORGED, "outcome": ESCAPES}
    raw: dict[str, bytes] = {
        "status: nothing": b"",
        "status: time of 1e300 s": encode_result({**STATE, "for_s": 1e300}),
        "status: release ..": encode_result({**STATE, "release": "../../.."}),
        "status: refusal forges a line": said + refusal,
        "status: escapes": encode_result({**STATE, **texts}),
        "status --json: escapes": encode_result({**STATE, **texts}),
        "logs: no answer": said,
        "logs: a line without an end": said + ENDLESS + b"x" * 4096,
        "logs: lines without an end": said + ENDLESS + b"evil\n" * 1000,
        "logs: refusal forges a line": said + refusal,
        "logs: escapes": said + f"{ESCAPES}\n".encode() + done,
        "logs: bytes": said + bytes(range(32)) * 3 + b"\xff\xfe\n" + done,
        "start: nested": b"\x1e" + b"[" * 1_000_000,
        "start: 8 MB of escapes": encode_result({**STATE, "reason": ESCAPES * 100_000}),
        "stop: release of text": encode_result({**STATE, "release": f"$({TOUCH})"}),
        "list: an answer without an end": said + b"\x1e" + ENDLESS + b"[" * 4096,
        "rollback: progress without an end": said + ENDLESS + encode_line({"text": ESCAPES}) * 50,
        "rollback: markup": encode_line({"text": "[/] [bold"}) + encode_result({**HEALTH, "outcome": FORGED}),
        "remove --yes: kept is text": encode_result({"has_recordings": "evil"}),
        "fetch: refusal forges a line": refusal,
    }
    for name, answer in raw.items():
        command = name.partition(":")[0].split()
        action = {"list": "releases", "fetch": "recordings"}.get(command[0], command[0])
        yield HostileRobot(name, tuple(command), {action: answer})


def _list_push_robots() -> Iterator[HostileRobot]:
    good = {
        "probe": encode_result(FACTS),
        "begin": encode_result(UPLOAD),
        "install": encode_result(INSTALLATION),
        "activate": encode_result(HEALTH),
        "discard": encode_result({}),
    }
    bad: dict[str, tuple[str, Any]] = {
        "facts of escapes": ("probe", {**FACTS, "host": FORGED, "system": ESCAPES}),
        "release of a shell": ("begin", {**UPLOAD, "release": f"$({TOUCH})"}),
        "sends to ..": ("begin", {**UPLOAD, "to": "../.."}),
        "sends to a shell": ("begin", {**UPLOAD, "to": f"a;{TOUCH}"}),
        "copies from a shell": ("begin", {**UPLOAD, "copy_from": f"`{TOUCH}`"}),
        "findings of escapes": ("install", {**INSTALLATION, "findings": [FINDING]}),
        "verdict of escapes": ("activate", {**HEALTH, "outcome": "unhealthy", "reason": FORGED, "lines": [ESCAPES]}),
    }  # fmt: skip
    for name, (action, answer) in bad.items():
        yield HostileRobot(f"push: {name}", ("push", "--skip-checks"), {**good, action: encode_result(answer)})


def _list_transfer_robots() -> Iterator[HostileRobot]:
    sender = 'exec rsync "$@"'
    scripts = {
        "rsync floods stderr": "yes evil | head -c 300000000 >&2; exit 23",
        "rsync writes escapes": f"printf '\\033]0;{CANARY}\\007\\033[2J error: forged\\n' >&2; exit 23",
        "rsync sends a folder": f"cd robotcore/recordings; rm *; mkdir {RECORDING}; cd ../..; {sender}",
        "rsync sends a program": f"chmod 6755 robotcore/recordings/*; {sender}",
        "rsync sends more": f"head -c 60000000 /dev/zero > robotcore/recordings/{RECORDING}; {sender}",
        "rsync sends a link": f"ln -sf ../../../app.py robotcore/recordings/{RECORDING}; {sender}",
    }  # fmt: skip
    for name, script in scripts.items():
        yield HostileRobot(
            name, ("fetch",), {"recordings": encode_list(RECORDING)}, write_recordings=_recording, rsync=script
        )


def _put(name: str, home: Path) -> None:
    (home / name).write_text("evil")


def _link(name: str, leads: str, home: Path) -> None:
    (home / name).symlink_to(leads)


_recording = partial(_put, RECORDING)


def _program(home: Path) -> None:
    (home / "evil.mcap").write_text(f"#!/bin/sh\n{TOUCH}")
    (home / "evil.mcap").chmod(0o6755)


def _traps(home: Path) -> None:
    _recording(home)
    _link("evil.mcap", "/etc/hostname", home)
    os.mkfifo(home / "pipe.mcap")


def _link_file(leads: str, client: Path) -> None:
    (client / "recordings" / "robot").mkdir(parents=True)
    _link(f"recordings/robot/{RECORDING}", str(client / leads), client)


def _link_folder(name: str, client: Path) -> None:
    (client / "elsewhere").mkdir()
    (client / name).parent.mkdir(parents=True, exist_ok=True)
    _link(name, str(client / "elsewhere"), client)


_GROUPS = (
    _list_file_robots,
    _list_list_robots,
    _list_answer_robots,
    _list_push_robots,
    _list_transfer_robots,
)
