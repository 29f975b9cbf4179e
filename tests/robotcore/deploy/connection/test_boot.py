from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.connection import boot
from tests.robotcore.deploy.actions import ECHO, Aboard

NASTY = {"a b": 'it\'s "so" $(touch canary) `x` \\ \n \0 ü \udcff \U0001f916', "n": [1, 2.5, None, True]}


def answers(script: str, folder: Path) -> list[dict[str, Any]]:
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-"], input=script.encode("ascii"), capture_output=True, cwd=folder, check=False
    )
    assert done.stderr == b""
    return [json.loads(line) for line in done.stdout.decode().split(MARK)[1:]]


def test_a_call_needs_nothing_there_but_pythons_standard_library(aboard: Aboard, tmp_path: Path) -> None:
    aboard("echo", ECHO)
    begun, done = answers(boot.script("echo", NASTY), tmp_path)
    assert begun == {"begun": "echo"}
    assert done == {"done": {"told": NASTY}}
    assert not list(tmp_path.iterdir())


IMPORT_ALL = """
from importlib import import_module

def act(layout, files):
    names = [file.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for file in files]
    return {"files": [import_module(name).__file__ for name in names]}
"""


def test_all_that_works_on_the_robot_is_sent_and_stands_alone(aboard: Aboard, tmp_path: Path) -> None:
    sent = {"files": sorted(boot.sources())}
    aboard("import_all", IMPORT_ALL)
    assert answers(boot.script("import_all", sent), tmp_path)[-1] == {"done": sent}


def test_a_python_that_is_too_old_is_told_in_words(tmp_path: Path) -> None:
    script = boot.script("probe", {}).replace("OLDEST = (3, 10)", "OLDEST = (9, 0)")
    _, refused = answers(script, tmp_path)
    version = sys.version.split()[0]
    assert refused["refused"]["fault"] == f"its Python is {version}, robotcore needs 9.0 or newer"
    assert refused["refused"]["kind"] == "python"


def test_what_is_read_first_has_no_new_syntax() -> None:
    with pytest.raises(SyntaxError):
        ast.parse("(a := 1)", feature_version=(3, 7))
    ast.parse(boot.script("probe", {}), feature_version=(3, 7))


def test_what_fails_there_is_told_by_its_file_and_line(aboard: Aboard) -> None:
    aboard("fail", "def act(layout):\n    return 1 / 0\n")
    script = boot.script("fail", {}).encode("ascii")
    done = subprocess.run([sys.executable, "-I", "-"], input=script, capture_output=True, check=False)
    assert b'agent/fail_for_test.py", line 2, in act' in done.stderr
