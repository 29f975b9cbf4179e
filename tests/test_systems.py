"""Other systems: what the code imports and names, and its errors where POSIX is missing."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import pytest

import robotcore

ROOT = Path(robotcore.__file__).parent.parent

LINUX_ONLY = {
    "robotcore.sweep.supervisor": "adopts orphaned processes, an ability of the kernel of Linux",
    "drivers.raspberrypi.loopback.stops": "ends programs on a Pi by the signals of POSIX",
    "drivers.raspberrypi.loopback.raspberry_pi": "tests a Pi, and imports `stops`",
}
"""The modules that need Linux when they are imported, with the reason. Others import on every system."""

TYPED_LINUX_ONLY = {
    "robotcore/sweep/supervisor.py": "adopts orphaned processes, an ability of the kernel of Linux",
    "robotcore/simulation/render_worker/client.py": "shares memory by memfd_create; elsewhere the run renders itself",
    "robotcore/runtime/active_runs.py": "finds processes in /proc; elsewhere it raises an error before",
    "robotcore/processes.py": "finds processes in /proc; elsewhere it returns an empty list before",
    "robotcore/safety/real_time.py": "sets priorities of Linux; elsewhere --rt is refused",
    "robotcore/cli/estop_key.py": "reads a POSIX terminal; elsewhere a run has a note",
    "robotcore/cli/app_terminal.py": "opens a pseudo-terminal for an app beside estop_key.py",
    "robotcore/hardware/firmware/board.py": "asks a board by a POSIX terminal; elsewhere it raises an error before",
    "robotcore/deploy/": "uses ssh and the permissions of POSIX; elsewhere it raises an error before",
    "drivers/raspberrypi/": "uses the devices of Linux; elsewhere it raises an error before",
}
"""The files that name what Windows lacks, with the reason why no other system comes to these lines."""

NAMES_OF_SYSTEM = {"sys.platform", "os.name", "platform.system"}


def _compares_system(node: ast.AST) -> bool:
    """Return whether a node compares the name of the system, or asks for its beginning."""
    is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "startswith"
    if not (isinstance(node, (ast.Compare, ast.Match)) or is_method):
        return False
    parts = node.subject if isinstance(node, ast.Match) else node
    return any(ast.unparse(each) in NAMES_OF_SYSTEM for each in ast.walk(parts) if isinstance(each, ast.Attribute))


def test_only_the_module_of_the_systems_compares_their_names() -> None:
    files = (file for package in ("robotcore", "drivers", "apps") for file in (ROOT / package).rglob("*.py"))
    sources = {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}
    named = {file: text for file, text in sources.items() if any(name in text for name in NAMES_OF_SYSTEM)}
    found = {file for file, text in named.items() if any(map(_compares_system, ast.walk(ast.parse(text))))}
    assert found == {"robotcore/system.py"}


IMPORT_ALL = """
import importlib, json, pkgutil, runpy, sys
runpy.run_path(sys.argv[1])["hide"]()
import apps, drivers, robotcore
failures = {}
for package in (robotcore, drivers, apps):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if ".templates" in module.name:
            continue
        try:
            importlib.import_module(module.name)
        except Exception as error:
            failures[module.name] = repr(error)
print(json.dumps(failures))
"""


def run_hidden(code: str, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run code in a Python in which POSIX is hidden from the project."""
    return subprocess.run(
        [sys.executable, "-c", code, str(ROOT / "tests/no_posix.py"), *arguments],
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
        env={**os.environ, **variables},
    )


@pytest.mark.slow
def test_every_module_imports_without_posix() -> None:
    done = run_hidden(IMPORT_ALL)
    assert done.returncode == 0, done.stderr
    assert set(json.loads(done.stdout)) == set(LINUX_ONLY), done.stdout


@pytest.mark.slow
@pytest.mark.timeout(600)  # without a cache, the type checker needs a minute on a busy machine
def test_only_the_listed_files_name_what_windows_lacks(tmp_path: Path) -> None:
    """The type checker knows the names of Windows. It skips the code behind HAS_POSIX and IS_LINUX."""
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--platform", "win32", "--cache-dir", str(tmp_path)]
    constants = ("--config-file", str(ROOT / "tests/win32.ini"))
    done = subprocess.run(
        [*command, *constants, "robotcore", "drivers", "apps"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    found = {line.partition(":")[0] for line in done.stdout.splitlines() if ": error:" in line}
    assert done.returncode < 2, done.stdout + done.stderr
    unlisted = {file for file in found if not file.startswith(tuple(TYPED_LINUX_ONLY))}
    assert not unlisted, "\n".join(line for line in done.stdout.splitlines() if line.startswith(tuple(unlisted)))
    assert all(any(file.startswith(listed) for file in found) for listed in TYPED_LINUX_ONLY), sorted(found)


COMMAND = """
import runpy, sys
runpy.run_path(sys.argv.pop(1))["hide"]()
from robotcore.cli.main import main
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments, status, text",
    [
        (["deploy", "status", "pi@rover"], 3, "robotcore deploy needs"),
        (["run", "avoid-obstacles", "--backend", "raspberrypi"], 3, "the backend 'raspberrypi' needs"),
        (["stop"], 3, "robotcore stop without --backend needs"),
        (["stop", "--backend", "raspberrypi"], 3, "the backend 'raspberrypi' needs"),
        (["doctor", "--loopback", "--backend", "raspberrypi"], 3, "the backend 'raspberrypi' needs"),
        (["firmware", "flash", "--port", "COM3"], 3, "robotcore firmware flash needs"),
        (
            ["run", "avoid-obstacles", "--backend", "serial", "--port", "COM3", "--robot", "rover"],
            3,
            "there is no COM3",
        ),
    ],
    ids=["deploy", "raspberrypi", "stop", "stop-raspberrypi", "loopback", "firmware", "serial"],
)
def test_a_command_that_needs_posix_says_so(arguments: list[str], status: int, text: str) -> None:
    done = run_hidden(COMMAND, *arguments)
    assert (done.returncode, "Traceback" in done.stderr) == (status, False), done.stderr
    assert text in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["--help"], ["deploy", "--help"], ["backends"], ["run", "--help"], ["wiring", "rover"]]
)
def test_other_commands_work_without_posix(arguments: list[str]) -> None:
    done = run_hidden(COMMAND, *arguments)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_a_pipe_whose_encoding_lacks_a_character_gets_a_question_mark() -> None:
    """A pipe on Windows has the encoding cp1252 by default. The remedies of the doctor have an arrow."""
    done = run_hidden(COMMAND, "doctor", "--backend", "kinematic", PYTHONIOENCODING="ascii")
    assert "Traceback" not in done.stderr
    assert done.returncode == 0, done.stderr


RESERVED = set('<>:"|?*') | {chr(code) for code in range(32)}


@pytest.mark.slow
def test_the_files_of_a_recorded_run_and_a_sweep_have_names_of_windows(tmp_path: Path) -> None:
    for arguments in (
        ["run", "avoid-obstacles", "--timeout", "2", "--record", "a.mcap", "--record-last", "1s", "--picture", "a.png"],
        ["sweep", "avoid-obstacles", "--seeds", "1-2", "--timeout", "1", "--report", "report", "--jobs", "1"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", "robotcore", *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert "Traceback" not in done.stderr, done.stderr
    names = [path.name for path in tmp_path.rglob("*")]
    assert {"a.mcap", "results.jsonl", "index.html"} <= set(names)
    assert [
        name for name in names if RESERVED & set(name) or name[-1] in ". " or PureWindowsPath(name).is_reserved()
    ] == []
