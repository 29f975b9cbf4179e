"""Fixtures for programs on the tests' simulated lines."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.drivers.raspberrypi.lines import END_S, ROOT, Launch, Lines, Program


@pytest.fixture
def lines(tmp_path: Path) -> Lines:
    return Lines(tmp_path)


@pytest.fixture
def launch(lines: Lines) -> Iterator[Launch]:
    """Start a Python module on the lines; its processes are killed after the test."""
    programs: list[Program] = []

    def launch(*module: str, stdin: int = subprocess.DEVNULL) -> Program:
        program = subprocess.Popen(
            [sys.executable, "-m", *module],
            cwd=ROOT,
            env=lines.environment,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        programs.append(program)
        return program

    yield launch
    for program in programs:
        program.kill()
        program.communicate(timeout=END_S)
