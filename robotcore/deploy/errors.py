"""Errors of ssh, rsync and a robot's answers: the patterns of known messages, each with a remedy."""

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
"""What ssh exits with when it is not the command there that failed."""

COMMAND_NOT_FOUND = 127

BROKEN = "broken"
"""The kind of a DeployError for a connection that broke."""

DAMAGED = "damaged"
"""The kind of a DeployError for a malformed answer of a robot."""


_FILES = {"file", "key"}
"""The groups of a pattern that are files on this machine."""


@dataclass(frozen=True)
class KnownFailure:
    """A known failure of ssh or rsync.

    In ``fault`` and ``remedy``, ``{host}`` is the host as the user wrote it, ``{login}`` the host as ssh takes it, and
    a group of the pattern stands by its name, quoted for a shell in ``remedy``.
    """

    pattern: str
    """The regular expression that finds the message."""

    kind: str
    """The kind of the error."""

    fault: str
    """What happened."""

    remedy: str
    """What to do."""

    def match(self, host: Host, said: str, folders: Iterable[Path] = (), **more: str) -> DeployError | None:
        """Return the error, if this is what was said; ``more`` goes into its words by name.

        A file that is named must lie in one of the ``folders``: a robot may have written what was said.
        """
        found = re.search(self.pattern, said, re.DOTALL | re.MULTILINE)
        if not found or not all(_is_within(found[name], folders) for name in _FILES & found.re.groupindex.keys()):
            return None
        known = {"host": host, "login": _login(host), **more}
        quoted = {name: shlex.quote(group) for name, group in found.groupdict("").items()}
        fault, remedy = self.fault.format(**found.groupdict(), **known), self.remedy.format(**quoted, **known)
        return DeployError(f"{host}: {fault}. {remedy}", kind=self.kind)


SSH_FAILURES = (
    KnownFailure(
        r"\A(?P<line>[^\n]+ line \d+: [^\n]+)",
        "configuration",
        "ssh does not understand its configuration: {line}",
        "Mend it, or take another file: --ssh-config FILE",
    ),
    KnownFailure(
        r"^ssh: Could not resolve hostname (?P<name>[^\s:]+)",
        "unknown",
        "there is no host of the name {name}",
        "Is it switched on, in this network, and spelt so? Its address does as well: pi@192.168.1.20",
    ),
    KnownFailure(
        r"^ssh: connect to host \S+ port (?P<port>\d+): Connection refused",
        "refused",
        "it is there, but nothing answers at port {port}",
        "Is the port right? If so, switch ssh on there: sudo systemctl enable --now ssh",
    ),
    KnownFailure(
        r"^ssh: connect to host [^\n]*: (?:No route to host|Network is unreachable|Host is down)",
        "no-route",
        "there is no way to it",
        "Is it switched on, and in the same network as this machine?",
    ),
    KnownFailure(
        r"^(?:ssh: connect to host|Connection) [^\n]*timed out",
        "time-out",
        "it does not answer",
        "Is it switched on, in this network, and does no firewall keep ssh out?",
    ),
    KnownFailure(
        r"^(?:kex_exchange_identification|Connection (?:closed|reset) by)",
        "hung-up",
        "it hung up before the login",
        "Is it ssh that answers there? If so, too many logins may have failed: wait some minutes",
    ),
    KnownFailure(
        r"^@ +WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED!.*^Offending \S+ key in (?P<file>[^\n]+):\d+.*"
        r"^[^\n]*[Hh]ost key for (?P<known>\S+) has changed",
        "host-key-changed",
        "it shows another host key than before: it was installed anew, or something else answers in its name",
        "If it was installed anew, forget the old key: ssh-keygen -f {file} -R {known}",
    ),
    KnownFailure(
        r"^Host key verification failed",
        "host-key-unknown",
        "its host key is not known here, and nobody could be asked",
        "Log in once, and compare the key: ssh {login}",
    ),
    KnownFailure(
        r"^Permissions \S+ for '(?P<key>[^']+)' are too open",
        "open-key",
        "others on this machine may read the key {key}, so ssh does not use it",
        "Close it: chmod 600 {key}",
    ),
    KnownFailure(
        r"^Received disconnect from [^\n]*Too many authentication failures",
        "denied",
        "it has had enough of keys that are not the right one",
        "Offer it one alone, by IdentityFile and IdentitiesOnly in ~/.ssh/config",
    ),
    KnownFailure(
        r"^(?P<user>[^\s@]+)@\S+: Permission denied \((?P<ways>[^)]*)\)",
        "denied",
        "it does not let {user} in; it would take: {ways}",
        "Is the user right? A key is put there with: ssh-copy-id {login}",
    ),
)
"""Before the connection is there; the first that fits counts."""

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
        "its login shell prints something where nobody looks, and rsync takes it for an answer",
        "Let it print only where somebody is: case $- in *i*) … esac in ~/.bashrc there",
    ),
    KnownFailure(
        r"remote command not found|rsync: (?:[Cc]ommand )?not found|Unknown command:? '?rsync",  # any shell's words
        "no-rsync",
        "there is no rsync",
        "Install it there: sudo apt install rsync",
    ),
    KnownFailure(
        r"unknown option|unrecognized option",
        "old-rsync",
        "rsync here is not the one it should be, or too old",
        "Get rsync 3.1 or newer; macOS brings another one: brew install rsync",
    ),
)
"""Of a transfer over a connection that is still there; ``{where}`` is the side that is written to."""


def program_missing(name: str, package: str) -> DeployError:
    """Return the error for a program that is missing on this machine."""
    return DeployError(f"{name} is not installed here. Get it: sudo apt install {package}", kind="no-program")


def connection_failed(host: Host, status: int, said: str, config: Path | None = None) -> DeployError:
    """Return the error for a connection that did not come about: ssh's exit status, and what was said.

    The robot chooses the reason of a disconnect, so what follows the first line of it is not searched. A remedy names
    files of ``~/.ssh`` and of the folder of ``config`` only.
    """
    by_hand = f"Try it by hand: ssh {_login(host)}"
    if status == SSH_FAILED:
        folders = [Path.home() / ".ssh", *([config.parent] if config else [])]
        own = re.sub(r"(?ms)(^Received disconnect from [^\n]*).*", r"\1", said)
        return _match_failure(SSH_FAILURES, host, own, folders) or DeployError(
            f"{host}: ssh says: {last_line(said)}. {by_hand}"
        )
    return DeployError(f"{host}: its login shell ended at once (status {status}): {last_line(said)}. {by_hand}")


def login_timed_out(host: Host, seconds: float) -> DeployError:
    """Return the error for a robot that lets somebody in and then says nothing."""
    problem = f"nothing came back within {seconds:g} s of the login"
    return DeployError(f"{host}: {problem}. Does its login shell wait for something? ssh {_login(host)}")


def connection_lost(host: Host, said: str) -> DeployError:
    """Return the error for a connection that broke, by what ssh said of it."""
    words = f" ({last})" if (last := last_line(said)) else ""
    return DeployError(
        f"{host}: the connection broke{words}. Is it still switched on, and near? Try again", kind=BROKEN
    )


def call_failed(host: Host, status: int, said: str) -> DeployError:
    """Return the error for a call that ended without an answer: its exit status, and what it wrote on stderr."""
    if status == COMMAND_NOT_FOUND:
        return DeployError(f"{host}: there is no python3. Install it there: sudo apt install python3", kind="python")
    return DeployError(
        f"{host}: it failed there (status {status}): {last_line(said)}. Look at it there: ssh {_login(host)}"
    )


def damaged_answer(host: Host, action: str, problem: str) -> DeployError:
    """Return the error for an answer that is not as it has to be."""
    return DeployError(
        f"{host}: its answer to {action!r} is damaged: it {problem}. Check that it is the right robot and that its "
        f"system is intact: ssh {_login(host)}",
        kind=DAMAGED,
    )


def transfer_failed(host: Host, status: int, said: str, where: str) -> DeployError:
    """Return the error for a transfer that failed: rsync's exit status and words, and the side that is written to."""
    return _match_failure(RSYNC_FAILURES, host, said, where=where) or DeployError(
        f"{host}: rsync failed (status {status}): {first_line(said)}. What was there before is as it was"
    )


def first_line(said: str) -> str:
    """Return the first line of what was said: rsync's last one only points back."""
    return next((line.strip() for line in said.splitlines() if line.strip()), "nothing was said").rstrip(".")


def last_line(said: str) -> str:
    """Return the last line of what was said that has something in it, without its full stop."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1].rstrip(".") if lines else "nothing"


def _login(host: Host) -> str:
    """Return a host as ssh's own command line has it."""
    port = f"-p {host.port} " if host.port else ""
    return port + (f"{host.user}@{host.name}" if host.user else host.name)


def _match_failure(
    failures: Iterable[KnownFailure], host: Host, said: str, folders: Sequence[Path] = (), **more: str
) -> DeployError | None:
    return next((error for failure in failures if (error := failure.match(host, said, folders, **more))), None)


def _is_within(file: str, folders: Iterable[Path]) -> bool:
    """Return whether a file, with its links and ``..`` resolved, lies in one of these folders."""
    return any(Path(file).resolve().is_relative_to(folder.resolve()) for folder in folders)
