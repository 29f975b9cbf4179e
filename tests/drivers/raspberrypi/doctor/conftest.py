from __future__ import annotations

from pathlib import Path

import pytest

from tests.drivers.raspberrypi.doctor.trees import BROKEN, PI_4_BOOKWORM, PI_5_TRIXIE, grown


@pytest.fixture
def pi_4(tmp_path: Path) -> Path:
    return grown(tmp_path / "pi_4", PI_4_BOOKWORM)


@pytest.fixture
def pi_5(tmp_path: Path) -> Path:
    return grown(tmp_path / "pi_5", PI_5_TRIXIE)


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    return grown(tmp_path / "broken", BROKEN)
