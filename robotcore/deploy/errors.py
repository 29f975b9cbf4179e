"""Errors with a remedy for failures of ssh, of rsync and of a robot's answers."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from robotcore.deploy.agent.errors import MAKE_ROOM, KnownFailure, explain_known
from robotcore.deploy.host import RobotAddress
from robotcore.errors import DeployError

SSH_FAILED = 255
"""The exit status of ssh if ssh itself failed. Any other exit status of ssh is that of the remote command."""

BROKEN, DAMAGED = "broken", "damaged"
"""The kinds of a DeployError if the connection broke, and if a robot's answer is malformed."""

TRANSIENT = {
    BROKEN,
    "unknown-host",
    "refused",
    "no-route",
    "time-out",
    "no-ssh",
    "hung-up",
    "login-time-out",
    "ssh-failed",
}
"""The kinds of a DeployError after which a new attempt to connect may succeed, without a change by the user."""

CALL_FAILED, RSYNC_FAILED = "call-failed", "rsync-failed"
"""The kinds of a DeployError if a call or a transfer failed for an unknown reason, such as a broken connection."""

_FILES = {"file", "key"}
"""The named groups that match a file name on this machine, in `SSH_FAILURES`."""

SSH_FAILURES = (
    KnownFailure(
        r"\A(?P<line>[^\n]+ line \d+: [^\n]+)",
        "configuration",
        "the ssh configuration has an error: {line}",
        "Correct it, or name another file: --ssh-config FILE",
    ),
    KnownFailure(
        r"^ssh: Could not resolve hostname (?P<name>[^\s:]+)",
        "unknown-host",
        "the host name {name} was not found",
        "Check the spelling, and that the robot is on and in this network. Or use its address, such as pi@192.168.1.20",
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
        r"^Connection timed out during banner exchange",
        "no-ssh",
        "a program accepts the connection, but does not answer as ssh does",
        "Check the address and the port. If they are right, restart the robot",
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
        "the robot's host key is not known here, and ssh could not ask you",
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
"""The known failures of ssh before the connection is open. ``host`` is the robot, ``login`` the arguments of ssh."""

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
"""The known failures of rsync over an open connection. ``where`` is the machine that receives the files."""


def require_program(name: str, package: str) -> None:
    """Raise DeployError if a program is not installed on this machine."""
    if not shutil.which(name):
        raise DeployError(f"{name} is not installed here. Install it: sudo apt install {package}", kind="no-program")


def explain_failed_connection(host: RobotAddress, status: int, output: str) -> DeployError:
    """Return the error for a connection that could not be opened.

    status: ssh's exit status.
    output: the text that ssh or the login shell printed.
    """
    last = find_last_line(output)
    if status != SSH_FAILED:
        return DeployError(
            f"{host}: the login shell ended with status {status}: {last}. Try it by hand: ssh {host.login}",
            kind="login-shell-ended",
            status=status,
        )
    folders = [Path.home() / ".ssh", *([host.ssh_config.parent] if host.ssh_config else [])]

    def names_own_file(found: re.Match[str]) -> bool:
        # a robot could write a message that makes the user delete or change any file
        files = [Path(found[name]).resolve() for name in _FILES & found.re.groupindex.keys()]
        return all(any(file.is_relative_to(folder.resolve()) for folder in folders) for file in files)

    # the robot chooses the text of this message, and may add lines that look like messages of ssh
    own = re.sub(r"(?ms)(^Received disconnect from [^\n]*).*", r"\1", output)
    if known := explain_known(SSH_FAILURES, own, names_own_file, host=host, login=host.login):
        return DeployError(f"{host}: {known}", kind=known.kind)
    return DeployError(f"{host}: ssh failed: {last}. Try it by hand: ssh {host.login}", kind="ssh-failed")


def explain_damaged_answer(host: RobotAddress, action: str, problem: str) -> DeployError:
    """Return the error for a malformed answer of a robot.

    problem: a text that continues a sentence after the word ``it``, such as ``is not JSON``.
    """
    return DeployError(
        f"{host}: the robot's answer to {action!r} is damaged: it {problem}. Check that it is the right robot and that "
        f"its system is intact: ssh {host.login}",
        kind=DAMAGED,
        action=action,
    )


def explain_failed_transfer(host: RobotAddress, status: int, output: str, where: str) -> DeployError:
    """Return the error for a transfer that failed.

    status: rsync's exit status.
    output: the text that rsync printed on stderr.
    where: the machine that receives the files.
    """
    if known := explain_known(RSYNC_FAILURES, output, where=where):
        return DeployError(f"{host}: {known}", kind=known.kind)
    first = next((line.strip().rstrip(".") for line in output.splitlines() if line.strip()), "no message")
    return DeployError(
        f"{host}: rsync failed (status {status}): {first}. The previous files are unchanged",
        kind=RSYNC_FAILED,
        status=status,
    )


def find_last_line(output: str) -> str:
    """Return the last line that is not blank, without its full stop."""
    return next((line.strip().rstrip(".") for line in reversed(output.splitlines()) if line.strip()), "no message")
