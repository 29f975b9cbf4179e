"""Fixtures of the checks."""

from __future__ import annotations

import socket

import pytest


@pytest.fixture
def unused_port() -> int:
    with socket.create_server(("", 0)) as listening:
        return int(listening.getsockname()[1])
