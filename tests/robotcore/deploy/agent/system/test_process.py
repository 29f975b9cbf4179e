from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from robotcore.deploy.agent.system import process

CAT = str(shutil.which("cat"))


def test_a_process_is_known_as_long_as_it_lives() -> None:
    with subprocess.Popen(CAT, stdin=subprocess.PIPE) as cat:
        named = process.identity(cat.pid)
        assert process.is_alive(named)
    assert not process.is_alive(named)


def test_another_process_with_the_same_number_is_another_one() -> None:
    boot, pid, started = process.identity(os.getpid()).split()
    assert process.is_alive(f"{boot} {pid} {started}")
    assert int(started) > int(process.identity(1).split()[2])
    assert not process.is_alive(f"{boot} {pid} {int(started) - 1}")
    assert not process.is_alive(f"another-boot {pid} {started}")


def test_nonsense_is_nobody() -> None:
    assert not any(process.is_alive(named) for named in ("", "boot", "boot x 1", "boot 0 1", "boot -1 1"))


def test_a_program_may_be_called_as_it_likes(tmp_path: Path) -> None:
    program = tmp_path / "a) S 1 (b"
    shutil.copy(CAT, program)
    with subprocess.Popen([program], stdin=subprocess.PIPE) as cat:
        assert process.is_alive(process.identity(cat.pid))
        assert process.identity(cat.pid).split()[2].isdigit()
