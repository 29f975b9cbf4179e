from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

import pytest

from robotcore.hal.check_finding import Finding
from tests.drivers.raspberrypi.doctor.trees import BROKEN, PI_4_BOOKWORM, PI_5_TRIXIE, create_tree
from tests.texts import CheckText


@pytest.fixture
def pi_4(tmp_path: Path) -> Path:
    return create_tree(tmp_path / "pi_4", PI_4_BOOKWORM)


@pytest.fixture
def pi_5(tmp_path: Path) -> Path:
    return create_tree(tmp_path / "pi_5", PI_5_TRIXIE)


@pytest.fixture
def broken_tree(tmp_path: Path) -> Path:
    return create_tree(tmp_path / "broken_tree", BROKEN)


class CheckFindings(Protocol):
    """Compare findings with kinds, and with the texts of the snapshot."""

    def __call__(self, findings: Iterable[Finding], *kinds: str) -> None: ...


@pytest.fixture
def check_findings(check_text: CheckText) -> CheckFindings:
    """Compare the kinds of findings, and their levels, texts and remedies with the snapshot."""

    def check(findings: Iterable[Finding], *kinds: str) -> None:
        found = list(findings)
        assert [each.kind for each in found] == list(kinds)
        for each in found:
            check_text(f"{each.level.value}: {each.subject}: {each.message}\n{each.remedy}".strip())

    return check
