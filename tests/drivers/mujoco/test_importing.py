from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytest.importorskip("mujoco")


@pytest.mark.parametrize(
    "command", [("run", "avoid-obstacles", "--backend", "mujoco"), ("export", "rover", "--format", "mjcf")]
)
def test_an_opengl_that_mujoco_does_not_know_is_told_in_a_line(command: tuple[str, ...]) -> None:
    environment = {**os.environ, "MUJOCO_GL": "crayon"}
    told = subprocess.run(
        [sys.executable, "-m", "robotcore", *command], env=environment, capture_output=True, text=True, check=False
    )
    assert (told.returncode, told.stdout) == (3, "")
    assert told.stderr == (
        "error: MuJoCo cannot be imported: invalid value for environment variable MUJOCO_GL: crayon. "
        "Unset MUJOCO_GL, which is 'crayon': what works is found\n"
    )
