"""The address of a robot, and commands for it that a user can paste into a shell."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from ipaddress import AddressValueError, IPv6Address
from pathlib import Path

from robotcore.errors import UsageError

__all__ = ["RobotAddress"]

PATTERN = re.compile(
    r"(?:(?P<user>[A-Za-z0-9_][A-Za-z0-9_.-]{0,63})@)?"
    r"(?:(?P<name>[A-Za-z0-9_](?:[A-Za-z0-9_.-]{0,251}[A-Za-z0-9])?)"
    r"|\[(?P<address>[0-9A-Fa-f:.]{2,45}(?:%[A-Za-z0-9_.-]{1,15})?)\])"
    r"(?::(?P<port>[0-9]{1,5}))?"
)
"""The pattern of an address, without characters that are special for shells or for ssh.

A ``ProxyCommand`` in an ssh configuration passes the host name to a shell.
"""


@dataclass(frozen=True)
class RobotAddress:
    """The address of a robot for ssh.

    >>> print(RobotAddress.parse("pi@[fe80::1]"))
    pi@[fe80::1]
    """

    name: str
    """A host name, an IP address, or an alias of the user's ssh configuration."""
    user: str = ""
    """The user on the robot. If it is empty, ssh takes the user from its configuration."""
    port: int | None = None
    """The port of ssh on the robot. If it is None, ssh takes the port from its configuration."""
    ssh_config: Path | None = None
    """An ssh configuration in place of the user's."""

    @classmethod
    def parse(cls, text: str) -> RobotAddress:
        """Return the address in a text ``[user@]host[:port]``. An IPv6 address must be in brackets.

        Raises UsageError if the text is not of this form.
        """
        found = PATTERN.fullmatch(text)
        if not found or not _is_address(found["address"]) or not 0 < int(found["port"] or 22) < 1 << 16:
            raise UsageError(
                f"{text!r} is not the address of a robot. Write a name or an IP address, with user and port if needed: "
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

    @property
    def login(self) -> str:
        """The arguments of ssh and of ssh-copy-id that log in to the robot, for a remedy."""
        config = f"-F {shlex.quote(str(self.ssh_config))} " if self.ssh_config else ""
        port = f"-p {self.port} " if self.port else ""
        return config + port + (f"{self.user}@{self.name}" if self.user else self.name)

    def format_command(self, command: str) -> str:
        """Return a command line of ``robotcore deploy`` that a user can paste into a shell.

        command: the subcommand, such as ``logs``, with its options.

        >>> print(RobotAddress("rover", "pi", 2222, Path("lab of ours.ssh")).format_command("logs"))
        robotcore deploy logs pi@rover:2222 --ssh-config 'lab of ours.ssh'
        """
        config = ("--ssh-config", str(self.ssh_config)) if self.ssh_config else ()
        return shlex.join(["robotcore", "deploy", *command.split(), str(self), *config])


def _is_address(text: str | None) -> bool:
    try:
        return text is None or bool(IPv6Address(text))
    except AddressValueError:
        return False
