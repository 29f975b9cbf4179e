"""Explain why pip failed, from its output, and what to do about it."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterable
from dataclasses import dataclass

from robotcore.deploy.agent.files import MAKE_ROOM
from robotcore.deploy.agent.rpc import AgentError

_CORRECT_IT = "Correct it in the project's dependencies"


@dataclass(frozen=True)
class _Failure:
    """A failure of pip that its output identifies."""

    line: re.Pattern[str]
    """A line of the output, with at most one group."""
    kind: str
    fault: str
    """What happened, with ``{}`` for the line's group."""
    remedy: str


_COMMON = (
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
        "Loosen the project's requirements; pip install at the desk names the ones in conflict",
    ),
    _Failure(re.compile(r"Invalid requirement: '?([^'\n]+)"), "requirement", "{} is no requirement", _CORRECT_IT),
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
        "the robot does not trust the package index's certificate",
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
_UNKNOWN = _Failure(_NOT_FOUND, "requirement", "there is no {} for {here}", _CORRECT_IT)
_NOT_UPLOADED = _Failure(_NOT_FOUND, "wheels", "no wheel of {} for {here} was uploaded", "Push again with --offline")
_BUILDING = re.compile(r"Failed building wheel for|Failed to build|subprocess-exited-with-error")
_BUILT_PACKAGE = re.compile(r"Failed building wheel for ([\w.-]+)|╰─> ([\w.-]+)$|^Collecting ([\w.-]+)", re.MULTILINE)
_REASON = re.compile(r"^ *(.+)\n *\[end of output\]", re.MULTILINE)


def explain_failure(lines: Iterable[str], *, is_offline: bool) -> AgentError:
    """Return the error for pip's output. An unknown failure is quoted."""
    output = "\n".join(lines)
    for failure in (*_COMMON, _NOT_UPLOADED) if is_offline else (*_COMMON, *_NETWORK, _UNKNOWN):
        if found := failure.line.search(output):
            fault = failure.fault.format(*found.groups(), here=_describe_python())
            return AgentError(fault, failure.remedy, failure.kind)
    if _BUILDING.search(output):
        return _explain_build(output)
    return AgentError(f"pip failed on the robot: {_quote_errors(output)}", "Look at the project's dependencies", "pip")


def _explain_build(output: str) -> AgentError:
    """Return the error for a package that has no wheel and cannot be built."""
    name = next((filter(None, found.groups()) for found in reversed(list(_BUILT_PACKAGE.finditer(output)))), iter(()))
    reason = _REASON.findall(output)[-1:]
    fault = f"{next(name, 'a requirement')} has no wheel for {_describe_python()}, and cannot be built there"
    remedy = "Use another version, or the system's package if there is one: sudo apt install python3-NAME"
    return AgentError(": ".join([fault, *reason]), remedy, "wheels")


def _describe_python() -> str:
    return f"Python {platform.python_version()} on {platform.machine()}"


def _quote_errors(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return " / ".join(errors[:3] or lines[-3:])
