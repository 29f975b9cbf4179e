"""The user's own systemd: what it is asked, what it tells of a unit, and its failures in words."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass

from robotcore.deploy.agent import robot_facts
from robotcore.deploy.agent.rpc import AgentError

CALL_TIMEOUT_S = 90.0
"""How long systemd may take over a call: longer than it lets a service take to stop."""

EXITED, KILLED = 1, 2
"""``CLD_EXITED`` and ``CLD_KILLED`` of wait(2): a process ended by itself, or by a signal."""

_STATUSES = {
    2: "it cannot run as it is described",
    3: "a device or the backend failed",
    4: "the safety stage stopped it",
    5: "the app raised, or hung",
    6: "it ended without a success",
}
"""What ``robotcore run`` exits with as a service, in words."""

MANAGER_GONE = "manager"
"""The kind of a refusal where the user's systemd itself does not answer."""

_NO_BUS_TEXTS = (
    "Failed to connect to bus",
    "Transport endpoint is not connected",
    "Connection reset",
    "Connection terminated",
)
"""What systemctl prints where the user's systemd does not run, or ends meanwhile."""


@dataclass(frozen=True)
class UnitState:
    """What systemd tells of a unit, by the names of org.freedesktop.systemd1(5).

    ``active_since_s`` and ``alive_at_s``, when its loop last told the watchdog that it is alive, are of the monotonic
    clock. ``code`` and ``status`` are of the main process's end, as wait(2) has them. ``has_job`` is whether it is
    about to be started or stopped. ``invocation`` is another one each time the unit starts, by whatever cause.
    """

    active: str = "inactive"
    sub: str = "dead"
    result: str = "success"
    invocation: str = ""
    restarts: int = 0
    words: str = ""
    code: int = 0
    status: int = 0
    active_since_s: float = 0.0
    alive_at_s: float = 0.0
    is_enabled: bool = False
    has_job: bool = False

    @classmethod
    def of(cls, told: Mapping[str, str]) -> UnitState:
        """Return the state that properties tell of."""
        return cls(
            active=told["ActiveState"],
            sub=told["SubState"],
            result=told["Result"],
            invocation=told["InvocationID"],
            restarts=int(told["NRestarts"]),
            words=told["StatusText"],
            code=int(told["ExecMainCode"]),
            status=int(told["ExecMainStatus"]),
            active_since_s=int(told["ActiveEnterTimestampMonotonic"]) / 1e6,
            alive_at_s=int(told["WatchdogTimestampMonotonic"]) / 1e6,
            is_enabled=told["UnitFileState"] == "enabled",
            has_job=bool(told["Job"]),
        )

    @property
    def is_up(self) -> bool:
        """It runs, and has said that it is ready."""
        return self.active == "active"

    @property
    def is_starting(self) -> bool:
        """It is being started, or will be once more after a pause."""
        return self.active == "activating"

    @property
    def is_down(self) -> bool:
        """It ended without a failure, and nothing will start it again."""
        return self.active == "inactive" and not self.has_failed

    @property
    def is_between(self) -> bool:
        """It starts or stops, or is about to; a pause before it is started again is not that."""
        return self.has_job or (self.active in {"activating", "deactivating"} and self.sub != "auto-restart")

    @property
    def has_failed(self) -> bool:
        """It failed, whether or not it is being started again."""
        return self.result != "success" or self.active == "failed"

    @property
    def has_succeeded(self) -> bool:
        """It ended by itself, and well."""
        return self.is_down and (self.code, self.status) == (EXITED, 0)

    def ending(self) -> str:
        """Return in words how the main process ended."""
        if self.result == "watchdog":
            return "it hung: it told nothing to systemd's watchdog"
        if self.result == "timeout":
            return "it took too long to start or to stop"
        if self.result == "protocol":
            return f"it ended with status {self.status} before its first step"
        if self.code == EXITED:
            words = f" ({_STATUSES[self.status]})" if self.status in _STATUSES else ""
            return f"it ended with status {self.status}{words}"
        if self.code:
            return f"it was ended by {signal.Signals(self.status).name}"
        return f"systemd could not start it ({self.result})"


_PROPERTIES = (
    "ActiveState,SubState,Result,InvocationID,NRestarts,StatusText,ExecMainCode,ExecMainStatus,"
    "ActiveEnterTimestampMonotonic,WatchdogTimestampMonotonic,UnitFileState,Job"
)


def read_state(unit: str) -> UnitState:
    """Return what systemd tells of a unit; one that it does not know is down."""
    lines = systemctl("show", f"--property={_PROPERTIES}", unit).splitlines()
    return UnitState.of(dict(line.partition("=")[::2] for line in lines))


def restart(unit: str) -> str:
    """Let systemd stop and start a unit in one job, and do not wait for it; failures of before count no longer.

    Returns the invocation that this ends.
    """
    _forget_failures(unit)
    before = read_state(unit).invocation
    systemctl("restart", "--no-block", unit)
    return before


def start(unit: str) -> None:
    """Let systemd start a unit, and do not wait for it; failures of before count no longer."""
    _forget_failures(unit)
    systemctl("start", "--no-block", unit)


def stop(*units: str) -> None:
    """Stop units; return once they are down. What failed is forgotten, as what was stopped has not failed."""
    systemctl("stop", *units)
    _forget_failures(*units)


def _forget_failures(*units: str) -> None:
    """Forget them; systemd refuses that where it knows a disabled unit no more, and then there is nothing to forget."""
    _call("reset-failed", *units)


def enable(*units: str) -> None:
    """Let units start with the robot."""
    systemctl("enable", *units)


def disable(*units: str) -> None:
    """Let units no longer start with the robot."""
    systemctl("disable", *units)


def reload_units() -> None:
    """Let systemd read its units again."""
    systemctl("daemon-reload")


def is_shutting_down() -> bool:
    """Whether the robot, or this user's part of it, is about to end."""
    done = _call("is-system-running")
    return done.stdout.strip() not in {"running", "degraded", "starting", "initializing", "maintenance"}


def systemctl(*arguments: str) -> str:
    """Return what systemctl prints for the user's own systemd; raises RefusalError where it fails."""
    done = _call(*arguments)
    if done.returncode:
        raise _build_error(arguments, done.stderr.strip())
    return done.stdout


def _call(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = ("systemctl", "--user", "--no-ask-password", *arguments)
    try:
        return subprocess.run(  # noqa: S603 - constants and names of units
            command,
            env=robot_facts.build_environment(),
            capture_output=True,
            text=True,
            timeout=CALL_TIMEOUT_S,
            check=False,
        )
    except FileNotFoundError as error:
        raise AgentError(
            "there is no systemd here",
            "robotcore deploy needs it: Raspberry Pi OS, Debian and Ubuntu have it",
            "no-systemd",
        ) from error
    except subprocess.TimeoutExpired as error:
        raise AgentError(
            f"systemd did not answer to {arguments[0]} within {CALL_TIMEOUT_S:g} s", "Reboot the robot", MANAGER_GONE
        ) from error


def _build_error(arguments: tuple[str, ...], told: str) -> AgentError:
    if any(words in told for words in _NO_BUS_TEXTS):
        user = robot_facts.read_user()
        return AgentError(
            f"no systemd of {user}'s runs there ({told})",
            f"On the robot: sudo loginctl enable-linger {user} && sudo systemctl start user@{os.getuid()}.service",
            MANAGER_GONE,
        )
    return AgentError(
        f"systemctl --user {' '.join(arguments)}: {told.splitlines()[0] if told else 'failed'}",
        "Look at it there: systemctl --user status robotcore",
        "systemctl",
    )
