"""What to type next, with all that it takes to reach the same robot again."""

from __future__ import annotations

import shlex
from pathlib import Path

from robotcore.deploy.connection.host import Host


def typed(command: str, host: Host, ssh_config: Path | None = None) -> str:
    """Return a command of ``robotcore deploy`` as it is typed for a robot, quoted for a shell.

    >>> print(typed("logs", Host.parse("pi@rover:2222"), Path("lab of ours.ssh")))
    robotcore deploy logs pi@rover:2222 --ssh-config 'lab of ours.ssh'
    """
    reached_by = () if ssh_config is None else ("--ssh-config", str(ssh_config))
    return shlex.join(["robotcore", "deploy", *command.split(), str(host), *reached_by])
