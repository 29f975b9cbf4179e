from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip the tests of this folder if MuJoCo is not installed."""
    from drivers.mujoco.backend import MujocoBackend

    backend = MujocoBackend()
    if backend.is_installed:
        return
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.skip(reason=f"mujoco is not installed: {backend.remedy}"))
