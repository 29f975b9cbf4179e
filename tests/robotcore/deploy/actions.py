"""Actions for tests: modules of the robot's that are sent like all others."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.deploy.connection import boot

Aboard = Callable[[str, str], None]

ECHO = """
def act(layout, **told):
    return {"told": told}
"""

WAIT = """
import os, subprocess
from robotcore.deploy.agent.rpc import report_progress

def act(layout):
    child = subprocess.Popen(["sleep", "600"])
    report_progress(f"{os.getpid()} {child.pid}")
    child.wait()
    return {}
"""


@pytest.fixture
def aboard(monkeypatch: pytest.MonkeyPatch) -> Aboard:
    """Puts an action aboard, by its name and source."""
    added = boot.sources()

    def put(name: str, source: str) -> None:
        added[f"robotcore/deploy/agent/{name}_for_test.py"] = source
        added["robotcore/deploy/agent/rpc.py"] += f"\nACTIONS[{name!r}] = '{name}_for_test:act'\n"

    monkeypatch.setattr(boot, "sources", lambda: added)
    return put
