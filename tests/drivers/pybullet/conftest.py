from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent
NEEDS_NO_BULLET = {"test_missing.py"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip the tests of this folder that need Bullet if it is not installed."""
    from drivers.pybullet.backend import PyBulletBackend

    backend = PyBulletBackend()
    if backend.is_installed:
        return
    for item in items:
        if HERE in item.path.parents and item.path.name not in NEEDS_NO_BULLET:
            item.add_marker(pytest.mark.skip(reason=f"pybullet is not installed: {backend.remedy}"))
