"""The address of a robot, and commands for it that a user can paste into a shell."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from ipaddress import AddressValueError, IPv6Address
from pathlib import Path

from robotcore.errors import UsageError

PATTERN = re.compile(
    r"(?:(?P<user>[A-Za-z0-9_][A-Za-z0-9_.-]{0,63})@)?"
    r"(?:(?P<name>[A-Za-z0-9_](?:[A-Za-z0-9_.-]{0,251}[A-Za-z0-9])?)"
    r"|\[(?P<address>[0-9A-Fa-f:.]{2,45}(?:%[A-Za-z0-9_.-]{1,15})?)\])"
    r"(?::(?P<port>[0-9]{1,5}))?"
)
"""The pattern of an address. It allows only characters without a special meaning for shells and for ssh.

This matters because a ``ProxyCommand`` in an ssh configuration passes the name to a shell.
"""


@dataclass(frozen=True)
class Host:
    """The address of a robot.

    >>> Host.parse("pi@rover.local:2222")
    Host(name='rover.local', user='pi', port=2222)
    >>> print(Host.parse("pi@[fe80::1]"))
    pi@[fe80::1]
    """

    name: str
    """A host name, an IP address, or an alias of the user's ssh configuration."""
    user: str = ""
    """The name of the user on the robot. If it is empty, the ssh configuration decides."""
    port: int | None = None
    """The port of ssh on the robot. If it is None, the ssh configuration decides."""

    @classmethod
    def parse(cls, text: str) -> Host:
        """Return the host for a text ``[user@]host[:port]``; raises UsageError if the text is not of this form.

        An IPv6 address must be in brackets.
        """
        if not (found := PATTERN.fullmatch(text)) or not _is_address(found["address"]) or not _is_port(found["port"]):
            raise UsageError(
                f"{text!r} is no host. Write a name or an address, with a user and a port if you need them: "
                "pi@rover.local, rover:2222, pi@[fe80::1%wlan0]:22",
                kind="invalid-host",
                host=text,
            )
        port = int(found["port"]) if found["port"] else None
        return cls(found["name"] or found["address"], found["user"] or "", port)

    def __str__(self) -> str:
        user = f"{self.user}@" if self.user else ""
        name = f"[{self.name}]" if ":" in self.name else self.name
        return f"{user}{name}{f':{self.port}' if self.port else ''}"


def _is_address(text: str | None) -> bool:
    try:
        return text is None or bool(IPv6Address(text))
    except AddressValueError:
        return False


def _is_port(text: str | None) -> bool:
    return text is None or 0 < int(text) < 1 << 16


def command_hint(command: str, host: Host, ssh_config: Path | None = None) -> str:
    """Return a command of ``robotcore deploy`` for a robot, quoted for a shell.

    command: the subcommand, with options if needed.
    host: the robot.
    ssh_config: an ssh configuration in place of the user's.

    >>> print(command_hint("logs", Host.parse("pi@rover:2222"), Path("lab of ours.ssh")))
    robotcore deploy logs pi@rover:2222 --ssh-config 'lab of ours.ssh'
    """
    reached_by = () if ssh_config is None else ("--ssh-config", str(ssh_config))
    return shlex.join(["robotcore", "deploy", *command.split(), str(host), *reached_by])
