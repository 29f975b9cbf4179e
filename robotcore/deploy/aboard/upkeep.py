"""What a robot needs so that a release is kept running: the program, the units, a systemd that stays."""

from __future__ import annotations

from robotcore.deploy.aboard import facts, needs, program, sources, units
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.telling import RefusalError


def ensure(layout: Layout) -> None:
    """See to all that is needed; raises RefusalError where the user's systemd would end with the connection."""
    if not needs.lingers():
        user = facts.user()
        raise RefusalError(
            f"the app would end when {user} logs out: {user} does not linger",
            f"On the robot, once: sudo loginctl enable-linger {user}",
            "linger",
        )
    program.install(layout, sources)
    units.install(layout)
