from __future__ import annotations

from typing import Any

import pytest

from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.session import RunRequest, RunResult, run
from tests.robotcore.fakes import RigBackend
from tests.robotcore.runs import Runner


@pytest.fixture
def backend() -> RigBackend:
    return RigBackend()


@pytest.fixture
def perform(backend: RigBackend, monkeypatch: pytest.MonkeyPatch) -> Runner:
    """Return a function that runs an app on null devices."""

    def perform(app: Behaviour, request: RunRequest | None = None, **parts: Any) -> RunResult:
        monkeypatch.setattr("robotcore.runtime.plan.load_backend", lambda _: backend)
        monkeypatch.setattr("robotcore.runtime.plan.load_app", type)
        monkeypatch.setattr("robotcore.runtime.plan.configure", lambda *_: app)
        return run(request or RunRequest("an_app"), **parts)

    return perform
