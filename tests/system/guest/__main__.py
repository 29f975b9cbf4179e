"""Run files of checks in the guest: python -m tests.system.guest FILE..."""

from __future__ import annotations

import compileall
import subprocess
import sys

import pytest

from tests.system import needs
from tests.system.speed import scaled

CHECK_LIMIT_S = 15
"""The time limit of a check, on the reference machine."""

COMPILED = ("robotcore", "drivers")
READ = """
import cv2, gpiozero, robotcore.cli.main, robotcore.safety.guardian.process
from drivers.raspberrypi import chip, cutoff
chip.load()
"""
"""Imports that read the host's disk. The first program that does so is slow, so it runs before the checks."""

PLUGINS = ("-p", "pytest_timeout", "-p", "tests.system.guest.reporting", "-p", "no:cacheprovider")

if __name__ == "__main__":
    for folder in COMPILED:
        compileall.compile_dir(needs.ROOT / folder, quiet=1)
    subprocess.run([sys.executable, "-c", READ], check=True)
    sys.exit(pytest.main([*PLUGINS, f"--timeout={scaled(CHECK_LIMIT_S):.0f}", "--color=no", *sys.argv[1:]]))
