"""What a robot needs so that a release is kept running: the program, the units, a systemd that stays."""

from __future__ import annotations

from robotcore.deploy.aboard import needs, program, sources, units
from robotcore.deploy.aboard.layout import Layout


def ensure(layout: Layout) -> None:
    """See to all that is needed; raises RefusalError where the user's systemd would end with the connection."""
    needs.require_lingering()
    program.install(layout, sources)
    units.install(layout)
