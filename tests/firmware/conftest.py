from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from robotcore.hardware.firmware.board import shipped_sketch
from tests.firmware.host import Firmware

FLAGS = ("-std=gnu++11", "-O1", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined")
TRAPPING = "-fsanitize-undefined-trap-on-error"
"""Undefined behaviour ends the test's process. It detects overflows, although int has 32 bits here."""


@pytest.fixture(scope="session")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Firmware:
    if not (compiler := shutil.which("g++")):
        pytest.skip("needs g++ to compile the firmware's C++ for this computer")
    library = tmp_path_factory.mktemp("firmware") / "host.so"
    source = Path(__file__).with_name("host.cpp")
    subprocess.run([compiler, *FLAGS, TRAPPING, f"-I{shipped_sketch()}", source, "-o", library], check=True)
    return Firmware(library)
