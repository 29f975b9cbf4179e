from __future__ import annotations

import io
import zipfile

from robotcore.deploy import rpc
from robotcore.deploy.agent import systemd_units as units
from robotcore.deploy.agent.files import Layout


def test_equal_sources_make_an_equal_program(layout: Layout) -> None:
    layout.root.mkdir(parents=True)
    units.install_program(layout, rpc.read_agent_sources())
    before = layout.program.stat()
    units.install_program(layout, rpc.read_agent_sources())
    assert layout.program.stat().st_ino == before.st_ino, "it was not written again"


def test_changed_sources_replace_the_program(layout: Layout) -> None:
    layout.root.mkdir(parents=True)
    units.install_program(layout, {"robotcore/__init__.py": "old"})
    with layout.program.open("rb") as running:
        units.install_program(layout, {"robotcore/__init__.py": "new"})
        assert zipfile.ZipFile(io.BytesIO(running.read())).read("robotcore/__init__.py") == b"old"
    assert zipfile.ZipFile(layout.program).read("robotcore/__init__.py") == b"new"
    assert list(layout.root.iterdir()) == [layout.program]
