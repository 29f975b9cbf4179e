from __future__ import annotations

import pytest

from robotcore.hal.backend import load_backend


@pytest.fixture
def pybullet() -> None:
    """Skip the test if Bullet is not installed."""
    backend = load_backend("pybullet")
    if not backend.is_installed:
        pytest.skip(f"pybullet is not installed: {backend.remedy}")
