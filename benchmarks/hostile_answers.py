"""The answers and files of hostile robots. Each would harm a client that did not treat it as data."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.deploy_injection import CANARY, TOUCH

RELEASE = "2026-11-21T22-40-03Z"
RECORDING = f"{RELEASE}.mcap"
ENDLESS = b"\0endless\0"
"""The start of an answer whose next piece is repeated without an end."""

ESCAPES = f"\x1b]0;{CANARY}\x07\x1b[2J\x1b]52;c;cHduZWQ=\x07\r\x9b2J\u202e"
FORGED = f"no\nerror: forged. run: {TOUCH}"

STATE: dict[str, Any] = {
    "release": RELEASE,
    "verdict": "healthy",
    "on_trial": None,
    "last": None,
    "state": "running",
    "for_s": 3.0,
    "restarts": 0,
    "words": "",
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
BEGUN: dict[str, Any] = {"release": RELEASE, "to": f"incoming/{RELEASE}", "copy_from": None}
INSTALLED: dict[str, Any] = {"environment": "kept", "findings": []}
FINDING = {"level": "error", "what": ESCAPES, "said": FORGED, "remedy": ESCAPES}
JUDGED: dict[str, Any] = {
    "release": RELEASE,
    "outcome": "healthy",
    "reason": "",
    "lines": [],
    "current": RELEASE,
    "is_running": True,
    "is_standing": False,
}


@dataclass(frozen=True)
class HostileRobot:
    """A hostile robot: the command that meets it, its answer to each action, and the content of its home.

    ``furnish`` makes the robot's folder of recordings, ``desk`` the folder of the user; ``rsync`` is a script that
    answers in place of the robot's rsync.
    """

    name: str
    command: tuple[str, ...]
    answers: dict[str, bytes] = field(default_factory=dict)
    furnish: Callable[[Path], object] | None = None
    desk: Callable[[Path], object] | None = None
    rsync: str = ""


def line(message: Any) -> bytes:
    """Return a line of an answer."""
    return b"\x1e" + json.dumps(message).encode() + b"\n"


def done(value: Any) -> bytes:
    """Return the whole answer to a call."""
    return line({"begun": "x"}) + line({"done": value})


def listed(*names: Any, size: Any = 4, **more: Any) -> bytes:
    """Return a list of recordings."""
    each = {"bytes": size, "is_file": True, "is_being_written": False, **more}
    return done({"recordings": [{"name": name, **each} for name in names]})


def build_hostile_robots() -> list[HostileRobot]:
    """Return all robots, those of different commands in turn, so that the first few are a sample."""
    groups = [list(group()) for group in (_files, _lists, _damaged, _words, _pushes, _transfers)]
    rounds = max(map(len, groups))
    return [group[number] for number in range(rounds) for group in groups if number < len(group)]


def _files() -> Iterator[HostileRobot]:
    """Yield robots with hostile files among the recordings, and valid answers."""
    fetch = ("fetch",)
    names = (
        "evil.py", ".bashrc", ".hidden.mcap", "a b.mcap", f"$({TOUCH}).mcap", f"`{TOUCH}`.mcap", f"; {TOUCH};.mcap",
        "-e sh.mcap", "--rsh=sh.mcap", "two\nlines.mcap", f"{ESCAPES}.mcap", "ü.mcap",
        f"{'a' * 200}.mcap", "robot.toml",
    )  # fmt: skip
    for name in names:
        yield HostileRobot(f"file {ascii(name)[:40]}", fetch, furnish=partial(_put, name))
    for name, leads in {"link out": "/etc/hostname", "link to the app": "../../app.py", "link in": RECORDING}.items():
        yield HostileRobot(name, fetch, furnish=partial(_link, "evil.mcap", leads))
    yield HostileRobot("folder", fetch, furnish=lambda home: (home / "evil.mcap").mkdir())
    yield HostileRobot("program", fetch, furnish=_program)
    yield HostileRobot("link here, file there", fetch, furnish=_recording, desk=partial(_link_file, "app.py"))
    yield HostileRobot("dead link here", (*fetch, "--move"), furnish=_recording, desk=partial(_link_file, "new.py"))
    for name in ("recordings", "recordings/robot", "recordings/robot/.partial"):
        yield HostileRobot(f"{name} is a link", fetch, furnish=_recording, desk=partial(_link_folder, name))


def _lists() -> Iterator[HostileRobot]:
    """Yield robots with false lists of recordings."""
    lies: dict[str, bytes] = {
        "name of ../": listed("../../../../../etc/hostname.mcap"),
        "absolute name": listed("/etc/hostname.mcap"),
        "name of ..": listed(".."),
        "name with NUL": listed("a\0.mcap"),
        "name is a number": listed(5),
        "name is null": listed(None),
        "size is text": listed(RECORDING, size="4"),
        "size is NaN": listed(RECORDING, size=float("nan")),
        "size below 0": listed(RECORDING, size=-1),
        "size of 2^200": listed(RECORDING, size=1 << 200),
        "size of 2^60": listed(RECORDING, size=1 << 60),
        "larger than it says": listed(RECORDING, size=1),
        "smaller than it says": listed(RECORDING, size=1000),
        "not there": listed("absent.mcap"),
        "link called a file": listed("evil.mcap", size=5),
        "pipe called a file": listed("pipe.mcap", size=5),
        "twice the same": listed(RECORDING, RECORDING),
        "no list": done({"recordings": {}}),
        "a million names": listed(*("x" * 4,) * 1_000_000),
        "50 000 bad names": listed(*(f"{number}.py" for number in range(50_000))),
    }
    for name, answer in lies.items():
        yield HostileRobot(f"list: {name}", ("fetch", "--move"), {"recordings": answer}, furnish=_traps)


def _damaged() -> Iterator[HostileRobot]:
    """Yield robots with invalid answers."""
    said = line({"begun": "x"})
    raw: dict[str, bytes] = {
        "nothing": b"",
        "no JSON": b"\x1e{",
        "a list": line([]),
        "null": line(None),
        "no answer": said,
        "no keys": done({}),
        "answer is text": done("evil"),
        "nested": b"\x1e" + b"[" * 1_000_000,
        "a number of 5000 digits": b'\x1e{"done": ' + b"9" * 5000 + b"}",
        "not UTF-8": b'\x1e{"done": "\xff"}',
        "a lone surrogate": b'\x1e{"done": {"state": "\\ud800"}}',
        "infinite time": done({**STATE, "for_s": float("inf")}),
        "time of 1e300 s": done({**STATE, "for_s": 1e300}),
        "release ..": done({**STATE, "release": "../../.."}),
        "release of text": done({**STATE, "release": f"$({TOUCH})"}),
        "refusal without a fault": said + line({"refused": {}}),
        "progress of a number": said + line({"say": 5}),
        "a line without an end": said + ENDLESS + b"x" * 4096,
        "an answer without an end": said + b"\x1e" + ENDLESS + b"[" * 4096,
        "lines without an end": said + ENDLESS + b"evil\n" * 1000,
        "progress without an end": said + ENDLESS + line({"say": ESCAPES}) * 50,
    }
    for number, (name, answer) in enumerate(raw.items()):
        command = ("status", "logs", "start", "stop", "list", "rollback")[number % 6]
        action = {"list": "releases"}.get(command, command)
        yield HostileRobot(f"{command}: {name}", (command,), {action: answer})
    yield HostileRobot("remove: kept is text", ("remove", "--yes"), {"remove": done({"kept": "evil"})})


def _words() -> Iterator[HostileRobot]:
    """Yield robots whose texts have control characters or line breaks."""
    said = line({"begun": "x"})
    refusal = line({"refused": {"fault": FORGED + ESCAPES, "remedy": ESCAPES, "kind": ESCAPES}})
    for command in ("status", "logs", "fetch"):
        yield HostileRobot(
            f"{command}: refusal forges a line", (command,), {"recordings": refusal, command: said + refusal}
        )
    yield HostileRobot("logs: escapes", ("logs",), {"logs": said + f"{ESCAPES}\n".encode() + line({"done": {}})})
    yield HostileRobot(
        "logs: bytes", ("logs",), {"logs": said + bytes(range(32)) * 3 + b"\xff\xfe\n" + line({"done": {}})}
    )
    texts = {"words": ESCAPES, "reason": FORGED, "lines": [ESCAPES, FORGED], "state": FORGED, "verdict": ESCAPES}
    yield HostileRobot("status: escapes", ("status",), {"status": done({**STATE, **texts})})
    yield HostileRobot("status --json: escapes", ("status", "--json"), {"status": done({**STATE, **texts})})
    yield HostileRobot("start: 8 MB of escapes", ("start",), {"start": done({**STATE, "reason": ESCAPES * 100_000})})
    yield HostileRobot(
        "rollback: markup",
        ("rollback",),
        {"rollback": said + line({"say": "[/] [bold"}) + done({**JUDGED, "outcome": FORGED})},
    )


def _pushes() -> Iterator[HostileRobot]:
    """Yield robots with a hostile step of a push."""
    good = {
        "probe": done(FACTS),
        "begin": done(BEGUN),
        "install": done(INSTALLED),
        "activate": done(JUDGED),
        "discard": done({}),
    }
    bad: dict[str, tuple[str, Any]] = {
        "no facts": ("probe", {}),
        "facts of escapes": ("probe", {**FACTS, "host": FORGED, "system": ESCAPES}),
        "machine ../": ("probe", {**FACTS, "machine": "../../x"}),
        "glibc of 10^9": ("probe", {**FACTS, "libc_version": "2.999999999"}),
        "Python of a shell": ("probe", {**FACTS, "python": f"3.11.2; {TOUCH}"}),
        "release of a shell": ("begin", {**BEGUN, "release": f"$({TOUCH})"}),
        "sends to ..": ("begin", {**BEGUN, "to": "../.."}),
        "sends to a shell": ("begin", {**BEGUN, "to": f"a;{TOUCH}"}),
        "copies from a shell": ("begin", {**BEGUN, "copy_from": f"`{TOUCH}`"}),
        "findings of escapes": ("install", {**INSTALLED, "findings": [FINDING]}),
        "findings of numbers": ("install", {**INSTALLED, "findings": [5]}),
        "verdict of escapes": ("activate", {**JUDGED, "outcome": "unhealthy", "reason": FORGED, "lines": [ESCAPES]}),
        "verdict without lines": ("activate", {**JUDGED, "lines": None}),
    }  # fmt: skip
    for name, (action, answer) in bad.items():
        yield HostileRobot(f"push: {name}", ("push", "--skip-checks"), {**good, action: done(answer)})


def _transfers() -> Iterator[HostileRobot]:
    """Yield robots whose rsync is hostile."""
    sender = 'exec rsync "$@"'
    scripts = {
        "rsync floods stderr": "yes evil | head -c 300000000 >&2; exit 23",
        "rsync writes escapes": f"printf '\\033]0;{CANARY}\\007\\033[2J error: forged\\n' >&2; exit 23",
        "rsync writes noise": "head -c 1000000 /dev/urandom",
        "rsync says nothing it should": "echo no; exit 0",
        "rsync sends a folder": f"cd robotcore/recordings; rm *; mkdir {RECORDING}; cd ../..; {sender}",
        "rsync sends a program": f"chmod 6755 robotcore/recordings/*; {sender}",
        "rsync sends more": f"head -c 60000000 /dev/zero > robotcore/recordings/{RECORDING}; {sender}",
        "rsync sends a link": f"ln -sf ../../../app.py robotcore/recordings/{RECORDING}; {sender}",
    }  # fmt: skip
    for name, script in scripts.items():
        yield HostileRobot(name, ("fetch",), {"recordings": listed(RECORDING)}, furnish=_recording, rsync=script)


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


def _link_file(leads: str, desk: Path) -> None:
    (desk / "recordings" / "robot").mkdir(parents=True)
    _link(f"recordings/robot/{RECORDING}", str(desk / leads), desk)


def _link_folder(name: str, desk: Path) -> None:
    (desk / "elsewhere").mkdir()
    (desk / name).parent.mkdir(parents=True, exist_ok=True)
    _link(name, str(desk / "elsewhere"), desk)
