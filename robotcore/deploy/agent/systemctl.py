"""Calls of systemctl for the user's systemd: control a unit, read its state, and describe its failure."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass

from robotcore.deploy.agent import robot_facts
from robotcore.deploy.agent.errors import AgentError

CALL_TIMEOUT_S = 90.0
"""The time limit of a call of systemctl, in s. It is longer than the stop of a service may take."""

EXITED, KILLED = 1, 2
"""The codes ``CLD_EXITED`` and ``CLD_KILLED`` of waitid(2): a process ended by itself, or by a signal."""

_STATUSES = {
    2: "it cannot run as it is described",
    3: "a device or the backend failed",
    4: "the safety stage stopped it",
    5: "the app raised, or hung",
    6: "it ended without a success",
}
"""The meaning of the exit statuses of ``robotcore run`` as a service."""

MANAGER_GONE = "manager"
"""The kind of an AgentError if the user's systemd does not answer."""

_NO_BUS_TEXTS = (
    "Failed to connect to bus",
    "Transport endpoint is not connected",
    "Connection reset",
    "Connection terminated",
)
"""Texts that systemctl prints if the user's systemd does not run, or ends during the call."""


@dataclass(frozen=True)
class UnitState:
    """The state of a systemd unit. For ``active``, ``sub`` and ``result``, see org.freedesktop.systemd1(5)."""

    active: str = "inactive"
    sub: str = "dead"
    result: str = "success"
    invocation: str = ""
    """The identifier of the unit's last start."""
    restarts: int = 0
    """The number of restarts by systemd after failures."""
    status_text: str = ""
    """The last status text that the unit sent to systemd."""
    code: int = 0
    """`EXITED`, `KILLED`, or another ``si_code`` of the main process's end; 0 if the process has not ended."""
    status: int = 0
    """The exit status of the main process, or the signal that ended it."""
    active_since_s: float = 0.0
    """The time on the monotonic clock at which the unit became active, in s."""
    alive_at_s: float = 0.0
    """The time on the monotonic clock of the last reset of systemd's watchdog, in s."""
    is_enabled: bool = False
    """Whether systemd starts the unit at each boot of the robot."""
    has_job: bool = False
    """Whether systemd is about to start or stop the unit."""

    @classmethod
    def from_properties(cls, properties: Mapping[str, str]) -> UnitState:
        """Return the state for the properties that ``systemctl show`` prints."""
        return cls(
            active=properties["ActiveState"],
            sub=properties["SubState"],
            result=properties["Result"],
            invocation=properties["InvocationID"],
            restarts=int(properties["NRestarts"]),
            status_text=properties["StatusText"],
            code=int(properties["ExecMainCode"]),
            status=int(properties["ExecMainStatus"]),
            active_since_s=int(properties["ActiveEnterTimestampMonotonic"]) / 1e6,
            alive_at_s=int(properties["WatchdogTimestampMonotonic"]) / 1e6,
            is_enabled=properties["UnitFileState"] == "enabled",
            has_job=bool(properties["Job"]),
        )

    @property
    def is_up(self) -> bool:
        """Whether the unit runs and is ready."""
        return self.active == "active"

    @property
    def is_down(self) -> bool:
        """Whether the unit does not run, has not failed, and will not be restarted."""
        return self.active == "inactive" and not self.has_failed

    @property
    def is_changing(self) -> bool:
        """Whether the unit is starting or stopping, or is about to. In the pause before a restart, this is False."""
        return self.has_job or (self.active in {"activating", "deactivating"} and self.sub != "auto-restart")

    @property
    def has_failed(self) -> bool:
        """Whether the unit failed. systemd may be about to restart it."""
        return self.result != "success" or self.active == "failed"

    @property
    def has_succeeded(self) -> bool:
        """Whether the unit ended by itself with success."""
        return self.is_down and (self.code, self.status) == (EXITED, 0)

    def describe_end(self) -> str:
        """Return the cause of the main process's end, in words."""
        if self.result == "watchdog":
            return "it hung: it did not reset systemd's watchdog"
        if self.result == "timeout":
            return "it took too long to start or to stop"
        if self.result == "protocol":
            return f"it ended with status {self.status} before its first tick"
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
    """Return the state of a unit. An unknown unit is down."""
    lines = systemctl("show", f"--property={_PROPERTIES}", unit).splitlines()
    return UnitState.from_properties(dict(line.partition("=")[::2] for line in lines))


def restart(unit: str) -> str:
    """Make systemd restart a unit, without waiting. Return the identifier of the invocation before the restart."""
    _forget_failures(unit)
    before = read_state(unit).invocation
    systemctl("restart", "--no-block", unit)
    return before


def start(unit: str) -> None:
    """Make systemd start a unit, without waiting."""
    _forget_failures(unit)
    systemctl("start", "--no-block", unit)


def stop(*units: str) -> None:
    """Stop units, and wait until they are down."""
    systemctl("stop", *units)
    _forget_failures(*units)


def _forget_failures(*units: str) -> None:
    _call("reset-failed", *units)  # an error is ignored: a unit that is not loaded has no failures


def is_shutting_down() -> bool:
    """Return whether the robot or the user's systemd is shutting down."""
    done = _call("is-system-running")
    return done.stdout.strip() not in {"running", "degraded", "starting", "initializing", "maintenance"}


def systemctl(*arguments: str) -> str:
    """Run systemctl for the user's systemd, and return its output. Raises AgentError if it fails."""
    done = _call(*arguments)
    if done.returncode == 0:
        return done.stdout
    stderr = done.stderr.strip()
    if any(text in stderr for text in _NO_BUS_TEXTS):
        user = robot_facts.read_user()
        raise AgentError(
            f"the systemd of {user} does not run on the robot ({stderr})",
            f"On the robot: sudo loginctl enable-linger {user} && sudo systemctl start user@{os.getuid()}.service",
            MANAGER_GONE,
        )
    raise AgentError(
        f"systemctl --user {' '.join(arguments)}: {stderr.splitlines()[0].rstrip('.') if stderr else 'failed'}",
        "On the robot: systemctl --user status robotcore",
        "systemctl",
    )


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
        raise AgentError(*robot_facts.NO_SYSTEMD) from error
    except subprocess.TimeoutExpired as error:
        raise AgentError(
            f"systemd did not answer to {arguments[0]} within {CALL_TIMEOUT_S:g} s", "Reboot the robot", MANAGER_GONE
        ) from error
