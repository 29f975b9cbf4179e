"""Turn failures of ssh, of rsync and of a robot's answers into errors with a remedy.

The module has patterns of known messages.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.files import MAKE_ROOM
from robotcore.deploy.host import Host
from robotcore.errors import DeployError

SSH_FAILED = 255
"""The exit status of ssh if ssh itself failed. Any other exit status of ssh is that of the remote command."""

COMMAND_NOT_FOUND = 127
"""The exit status of a shell that did not find a command."""

BROKEN = "broken"
"""The kind of a DeployError for a connection that broke."""

DAMAGED = "damaged"
"""The kind of a DeployError for a malformed answer of a robot."""


CALL_FAILED, RSYNC_FAILED = "call-failed", "rsync-failed"
"""The kinds of a DeployError for a failure whose cause is unknown. The cause may be a broken connection."""

_FILES = {"file", "key"}
"""The named groups of a pattern whose text is the name of a file on this machine."""


@dataclass(frozen=True)
class KnownFailure:
    """A known failure of ssh or rsync.

    ``fault`` and ``remedy`` are formats. In them, ``{host}`` is the host as the user wrote it, and ``{login}`` the
    arguments with which ssh reaches this host. The name of each named group of the pattern stands for the group's text.
    In ``remedy``, this text is quoted for a shell.
    """

    pattern: str
    """The regular expression that finds the message."""

    kind: str
    """The kind of the error."""

    fault: str
    """What happened."""

    remedy: str
    """What to do."""

    def match(self, host: Host, output: str, folders: Iterable[Path] = (), **more: str) -> DeployError | None:
        """Return the error if the output contains the known message, else None.

        folders: the folders in which a file must lie that the message names. Otherwise a robot could write a message
            that names any file of the user.
        more: further values for the formats, by name.
        """
        found = re.search(self.pattern, output, re.DOTALL | re.MULTILINE)
        if not found or not all(_is_within(found[name], folders) for name in _FILES & found.re.groupindex.keys()):
            return None
        known = {"host": host, "login": _format_login(host), **more}
        quoted = {name: shlex.quote(group) for name, group in found.groupdict("").items()}
        fault, remedy = self.fault.format(**found.groupdict(), **known), self.remedy.format(**quoted, **known)
        return DeployError(f"{host}: {fault}. {remedy}", kind=self.kind)


SSH_FAILURES = (
    KnownFailure(
        r"\A(?P<line>[^\n]+ line \d+: [^\n]+)",
        "configuration",
        "the ssh configuration has an error: {line}",
        "Correct it, or name another file: --ssh-config FILE",
    ),
    KnownFailure(
        r"^ssh: Could not resolve hostname (?P<name>[^\s:]+)",
        "unknown",
        "the host name {name} was not found",
        "Check the spelling, and that the robot is on and in this network. Or use its address: pi@192.168.1.20",
    ),
    KnownFailure(
        r"^ssh: connect to host \S+ port (?P<port>\d+): Connection refused",
        "refused",
        "the robot refuses connections to port {port}",
        "Check the port. If it is right, start ssh on the robot: sudo systemctl enable --now ssh",
    ),
    KnownFailure(
        r"^ssh: connect to host [^\n]*: (?:No route to host|Network is unreachable|Host is down)",
        "no-route",
        "no network route to the robot",
        "Check that the robot is on, and in the same network as this machine",
    ),
    KnownFailure(
        r"^(?:ssh: connect to host|Connection) [^\n]*timed out",
        "time-out",
        "the robot does not answer",
        "Check that it is on and in this network, and that no firewall blocks ssh",
    ),
    KnownFailure(
        r"^(?:kex_exchange_identification|Connection (?:closed|reset) by)",
        "hung-up",
        "the robot closed the connection before the login",
        "Check that ssh uses this port. If it does, too many logins may have failed: wait some minutes",
    ),
    KnownFailure(
        r"^@ +WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED!.*^Offending \S+ key in (?P<file>[^\n]+):\d+.*"
        r"^[^\n]*[Hh]ost key for (?P<known>\S+) has changed",
        "host-key-changed",
        "the robot's host key has changed: its system was installed again, or another machine uses its name",
        "If its system was installed again, delete the old key: ssh-keygen -f {file} -R {known}",
    ),
    KnownFailure(
        r"^Host key verification failed",
        "host-key-unknown",
        "its host key is not known here, and ssh could not ask you",
        "Log in once, and compare the key: ssh {login}",
    ),
    KnownFailure(
        r"^Permissions \S+ for '(?P<key>[^']+)' are too open",
        "open-key",
        "other users of this machine may read the key {key}, so ssh does not use it",
        "Make it private: chmod 600 {key}",
    ),
    KnownFailure(
        r"^Received disconnect from [^\n]*Too many authentication failures",
        "denied",
        "too many authentication failures: ssh offered several wrong keys",
        "Offer one key only, by IdentityFile and IdentitiesOnly in ~/.ssh/config",
    ),
    KnownFailure(
        r"^(?P<user>[^\s@]+)@\S+: Permission denied \((?P<ways>[^)]*)\)",
        "denied",
        "the robot refuses the login of {user}. It accepts: {ways}",
        "Check the user. To install your key on the robot: ssh-copy-id {login}",
    ),
)
"""The known failures of ssh before the connection is open. The first one that matches is reported."""

RSYNC_FAILURES = (
    KnownFailure(
        r"No space left on device|Disk quota exceeded",
        "disk-full",
        "the disk of {where} is full",
        MAKE_ROOM,
    ),
    KnownFailure(
        r"is your shell clean",
        "unclean-shell",
        "the login shell of the robot prints text without a terminal, which rsync cannot parse",
        "Let it print in interactive shells only: case $- in *i*) … esac in ~/.bashrc on the robot",
    ),
    KnownFailure(
        r"remote command not found|rsync: (?:[Cc]ommand )?not found|Unknown command:? '?rsync",  # any shell's words
        "no-rsync",
        "rsync is missing on the robot",
        "On the robot: sudo apt install rsync",
    ),
    KnownFailure(
        r"unknown option|unrecognized option",
        "old-rsync",
        "rsync on this machine is too old, or another program",
        "Install rsync 3.1 or newer. On macOS: brew install rsync",
    ),
)
"""The known failures of rsync over an open connection. ``{where}`` is the machine that receives the files."""


def explain_missing_program(name: str, package: str) -> DeployError:
    """Return the error for a program that is missing on this machine."""
    return DeployError(f"{name} is not installed here. Install it: sudo apt install {package}", kind="no-program")


def explain_failed_connection(host: Host, status: int, output: str, config: Path | None = None) -> DeployError:
    """Return the error for a connection that could not be opened.

    The remedy names a file only if it is in ``~/.ssh`` or in the folder of the ssh configuration.

    status: ssh's exit status.
    output: what ssh or the login shell printed. The robot chooses the text of Received disconnect, so only
        the first line of that message is searched.
    config: the ssh configuration in place of the user's.
    """
    by_hand = f"Try it by hand: ssh {_format_login(host)}"
    last = find_last_line(output)
    if status == SSH_FAILED:
        folders = [Path.home() / ".ssh", *([config.parent] if config else [])]
        own = re.sub(r"(?ms)(^Received disconnect from [^\n]*).*", r"\1", output)
        return _match_failure(SSH_FAILURES, host, own, folders) or DeployError(
            f"{host}: ssh failed: {last}. {by_hand}", kind="ssh-failed"
        )
    return DeployError(
        f"{host}: the login shell ended with status {status}: {last}. {by_hand}",
        kind="login-shell-ended",
        status=status,
    )


def explain_login_timeout(host: Host, seconds: float) -> DeployError:
    """Return the error for a robot that sends nothing after the login."""
    return DeployError(
        f"{host}: the robot sent nothing within {seconds:g} s of the login. Check whether its login shell waits for "
        f"input: ssh {_format_login(host)}",
        kind="login-time-out",
        limit_s=seconds,
    )


def explain_lost_connection(host: Host, output: str) -> DeployError:
    """Return the error for a connection that broke; ``output`` is what ssh printed."""
    words = f" ({find_last_line(output)})" if output.strip() else ""
    return DeployError(
        f"{host}: the connection broke{words}. Check that the robot is on and in reach, and try again", kind=BROKEN
    )


def explain_failed_call(host: Host, status: int, output: str) -> DeployError:
    """Return the error for a call that ended without an answer.

    status: the exit status of the call.
    output: what the call printed on stderr.
    """
    if status == COMMAND_NOT_FOUND:
        return DeployError(
            f"{host}: python3 is missing on the robot. On the robot: sudo apt install python3", kind="python"
        )
    return DeployError(
        f"{host}: the call failed on the robot (status {status}): {find_last_line(output)}. Log in and look: "
        f"ssh {_format_login(host)}",
        kind=CALL_FAILED,
        status=status,
    )


def explain_damaged_answer(host: Host, action: str, problem: str) -> DeployError:
    """Return the error for an answer that the client does not accept.

    problem: the end of a sentence about the answer that begins with ``it``, such as ``is not JSON``.
    """
    return DeployError(
        f"{host}: the robot's answer to {action!r} is damaged: it {problem}. Check that it is the right robot and that "
        f"its system is intact: ssh {_format_login(host)}",
        kind=DAMAGED,
        action=action,
    )


def explain_failed_transfer(host: Host, status: int, output: str, where: str) -> DeployError:
    """Return the error for a transfer that failed.

    status: rsync's exit status.
    output: what rsync printed on stderr.
    where: the machine that receives the files.
    """
    return _match_failure(RSYNC_FAILURES, host, output, where=where) or DeployError(
        f"{host}: rsync failed (status {status}): {find_first_line(output)}. The previous files are unchanged",
        kind=RSYNC_FAILED,
        status=status,
    )


def find_first_line(output: str) -> str:
    """Return the first line with text, without its full stop.

    For rsync this line says more than the last one, which only repeats the exit status.
    """
    return next((line.strip() for line in output.splitlines() if line.strip()), "no message").rstrip(".")


def find_last_line(output: str) -> str:
    """Return the last line with text, without its full stop."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return lines[-1].rstrip(".") if lines else "no message"


def _format_login(host: Host) -> str:
    """Return the arguments of ssh that name the host."""
    port = f"-p {host.port} " if host.port else ""
    return port + (f"{host.user}@{host.name}" if host.user else host.name)


def _match_failure(
    failures: Iterable[KnownFailure], host: Host, output: str, folders: Sequence[Path] = (), **more: str
) -> DeployError | None:
    return next((error for failure in failures if (error := failure.match(host, output, folders, **more))), None)


def _is_within(file: str, folders: Iterable[Path]) -> bool:
    """Return whether a file lies in one of these folders, after links and ``..`` are resolved."""
    return any(Path(file).resolve().is_relative_to(folder.resolve()) for folder in folders)
