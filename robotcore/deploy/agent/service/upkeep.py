"""What a robot needs so that a release is kept running: the program, the units, a systemd that stays."""

from __future__ import annotations

from robotcore.deploy.agent import sources
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.service import program, units
from robotcore.deploy.agent.system import needs


def ensure(layout: Layout) -> None:
    """See to all that is needed; raises RefusalError where the user's systemd would end with the connection."""
    needs.require_lingering()
    program.install(layout, sources)
    units.install(layout)
