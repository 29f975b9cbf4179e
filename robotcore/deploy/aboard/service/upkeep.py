"""What a robot needs so that a release is kept running: the program, the units, a systemd that stays."""

from __future__ import annotations

from robotcore.deploy.aboard import sources
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.service import program, units
from robotcore.deploy.aboard.system import needs


def ensure(layout: Layout) -> None:
    """See to all that is needed; raises RefusalError where the user's systemd would end with the connection."""
    needs.require_lingering()
    program.install(layout, sources)
    units.install(layout)
