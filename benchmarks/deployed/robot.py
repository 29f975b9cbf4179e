"""A robot to deploy to: a Debian that systemd boots, and the desk's project for it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import machine, require
from tests.system.deploy.rover import BENCH, Rover


@contextmanager
def robot() -> Iterator[Rover]:
    """Boot one that drives; raises NotRunError where none can be booted."""
    require()
    with TemporaryDirectory(prefix="robotcore-desk-") as folder, machine() as target:
        target.boot()
        desk = Desk.of(Path(folder), target)
        rover = Rover(target, desk, Path(shutil.copytree(BENCH, Path(folder) / "bench")))
        desk.install(rover.project)
        rover.drive(2.0)
        yield rover
