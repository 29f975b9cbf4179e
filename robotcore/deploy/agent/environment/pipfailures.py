"""Why pip failed, by what it printed, and what to do about it."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterable
from dataclasses import dataclass

from robotcore.deploy.agent.system.disk import MAKE_ROOM
from robotcore.deploy.agent.telling import RefusalError

_CORRECT = "Correct it in the project's dependencies"


@dataclass(frozen=True)
class _Failure:
    """A line of pip's, with at most one name in it that goes into the fault as ``{}``, and what it comes to."""

    line: re.Pattern[str]
    kind: str
    fault: str
    remedy: str


_ANYWHERE = (
    _Failure(
        re.compile(r"No space left on device|Disk quota exceeded"),
        "disk",
        "the robot's disk is full",
        MAKE_ROOM,
    ),
    _Failure(
        re.compile(r"ResolutionImpossible"),
        "requirement",
        "the requirements contradict each other",
        "Loosen those of the project; pip install at the desk says which",
    ),
    _Failure(re.compile(r"Invalid requirement: '?([^'\n]+)"), "requirement", "{} is no requirement", _CORRECT),
)
_NETWORK = (
    _Failure(
        re.compile(r"CERTIFICATE_VERIFY_FAILED.*(?:expired|not yet valid)"),
        "network",
        "for the robot the package index's certificate is out of date",
        "Set its clock: sudo timedatectl set-ntp true",
    ),
    _Failure(
        re.compile(r"CERTIFICATE_VERIFY_FAILED"),
        "network",
        "the robot does not trust who answers for the package index",
        "Give pip there the certificate of your network (pip config set global.cert FILE), or push with --offline",
    ),
    _Failure(
        re.compile(
            r"Failed to establish a new connection|Max retries exceeded|Connection refused|ConnectTimeout"
            r"|Read timed out|name resolution|Network is unreachable|ProxyError"
        ),
        "network",
        "the robot does not reach the package index",
        "Connect it to a network, or push with --offline",
    ),
)
_NOT_FOUND = re.compile(r"No matching distribution found for ([^\s(]+)")
_NOT_THERE = _Failure(_NOT_FOUND, "requirement", "there is no {} for {here}", _CORRECT)
_NOT_BROUGHT = _Failure(_NOT_FOUND, "wheels", "no {} for {here} was brought", "Push again with --offline")
_BUILDING = re.compile(r"Failed building wheel for|Failed to build|subprocess-exited-with-error")
_BUILT = re.compile(r"Failed building wheel for ([\w.-]+)|╰─> ([\w.-]+)$|^Collecting ([\w.-]+)", re.MULTILINE)
_REASON = re.compile(r"^ *(.+)\n *\[end of output\]", re.MULTILINE)


def refusal_of(lines: Iterable[str], *, is_offline: bool) -> RefusalError:
    """Return what a failure comes to. What nobody knows is told in pip's own words."""
    told = "\n".join(lines)
    for failure in (*_ANYWHERE, _NOT_BROUGHT) if is_offline else (*_ANYWHERE, *_NETWORK, _NOT_THERE):
        if found := failure.line.search(told):
            fault = failure.fault.format(*found.groups(), here=_here())
            return RefusalError(fault, failure.remedy, failure.kind)
    if _BUILDING.search(told):
        return _unbuilt(told)
    return RefusalError(f"pip failed on the robot: {_in_its_words(told)}", "Look at the project's dependencies", "pip")


def _unbuilt(told: str) -> RefusalError:
    """Return the refusal of what has to be built, and cannot be."""
    name = next((filter(None, found.groups()) for found in reversed(list(_BUILT.finditer(told)))), iter(()))
    reason = _REASON.findall(told)[-1:]
    fault = f"{next(name, 'a requirement')} has no wheel for {_here()}, and cannot be built there"
    remedy = "Take another version of it, or the system's, where it has one: sudo apt install python3-NAME"
    return RefusalError(": ".join([fault, *reason]), remedy, "wheels")


def _here() -> str:
    return f"Python {platform.python_version()} on {platform.machine()}"


def _in_its_words(told: str) -> str:
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return " / ".join(errors[:3] or lines[-3:])
