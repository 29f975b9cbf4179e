"""Build the wheel and the source distribution, and use them in new environments without this repository.

python -m tests.system.package [FOLDER]

FOLDER has a wheel and a source distribution of this commit; without it, both are built. Each check prints a line.
"""

from __future__ import annotations

import filecmp
import json
import os
import subprocess
import sys
import tarfile
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.robotcore.test_python_versions import find_old_python
from tests.system import needs
from tests.system.speed import scaled

LIMIT_S = 300.0
"""The time limit of a command on the reference machine."""

SDIST_TESTS = ("tests/robotcore/description", "tests/robotcore/test_compatibility.py", "tests/compatibility")
"""Tests that need no extra and no network, which the source distribution runs on its own code."""

FILES = ("CHANGELOG.md", "CONTRIBUTING.md", "Containerfile", "LICENSE", "Makefile", "README.md", "pyproject.toml")
"""Files that a stranger needs to work with the source distribution."""

Check = Callable[[], str]
"""A check: it returns its problem, or an empty text."""


class Installation:
    """A new virtual environment with a package, used in a folder of its own."""

    def __init__(self, folder: Path, python: str = sys.executable) -> None:
        self.folder, self._environment = folder / "work", folder / "environment"
        self.folder.mkdir(parents=True)
        self.run(python, "-m", "venv", str(self._environment))

    def install(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Install packages by pip."""
        return self.call("python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *arguments)

    def call(self, program: str, *arguments: str, folder: str = ".") -> subprocess.CompletedProcess[str]:
        """Run a program of the environment."""
        return self.run(str(self._environment / "bin" / program), *arguments, folder=folder)

    def run(self, *command: str, folder: str = ".") -> subprocess.CompletedProcess[str]:
        hidden = {"PYTHONPATH", "VIRTUAL_ENV"}
        environment = {name: value for name, value in os.environ.items() if name not in hidden}
        return subprocess.run(
            command,
            cwd=self.folder / folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=scaled(LIMIT_S),
        )


def main(arguments: list[str]) -> bool:
    """Return whether every check passed."""
    with TemporaryDirectory(prefix="robotcore-package-") as scratch:
        folder = Path(scratch)
        dist = Path(arguments[0]).resolve() if arguments else _build(needs.ROOT, folder / "dist")
        is_passed = True
        for name, check in list_checks(dist, folder):
            problem = check()
            print(f"not ok  {name}\n          {problem}" if problem else f"ok      {name}", flush=True)
            is_passed &= not problem
        return is_passed


def list_checks(dist: Path, folder: Path) -> Iterator[tuple[str, Check]]:
    """Yield the name and the function of each check."""
    (wheel,), (sdist,) = dist.glob("robotcore-*.whl"), dist.glob("robotcore-*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder / "sdist", filter="data")
    (source,) = (folder / "sdist").iterdir()
    yield "the source distribution has what a stranger needs", lambda: _list_missing(source)
    yield "it builds the same wheel, byte for byte", lambda: _compare_wheels(source, wheel, folder / "again")
    yield "its tests pass on its own code", lambda: _test_source(source)
    new = Installation(folder / "new")
    yield "pip installs the wheel alone", lambda: _explain(new.install(str(wheel)))
    yield (
        "--version is that of the wheel",
        lambda: _expect(new.call("robotcore", "--version"), wheel.name.split("-")[1]),
    )
    yield "the demo finds the ball", lambda: _expect(new.call("robotcore", "demo"), "success  green-search")
    yield "an app runs", lambda: _expect_success(new.call("robotcore", "run", "green-search", "--seed", "7", "--json"))
    yield "a missing library is one line with its extra", lambda: _refuse_recording(new)
    yield "PyBullet is missing with a remedy", lambda: _refuse_pybullet(new)
    yield "new makes a project", lambda: _explain(new.call("robotcore", "new", "my-robot"))
    yield "the project's app runs", lambda: _run_project(new)
    yield "the project's tests pass", lambda: _explain(new.install("pytest")) or _test_project(new)
    if old := find_old_python():
        yield f"pip refuses the wheel on {old.name}", lambda: _refuse_wheel(folder / "refused", old, wheel)
        yield f"a forced install on {old.name} gets one line", lambda: _refuse_python(folder / "forced", old, wheel)


def _build(source: Path, folder: Path, *options: str) -> Path:
    command = [sys.executable, "-m", "build", "--outdir", str(folder), *options, str(source)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise needs.NotRunError(f"needs to build the package: {needs.last_line(run.stdout + run.stderr)}")
    return folder


def _list_missing(source: Path) -> str:
    return ", ".join(f"{name} is missing" for name in FILES if not (source / name).is_file())


def _compare_wheels(source: Path, wheel: Path, folder: Path) -> str:
    again = _build(source, folder, "--wheel") / wheel.name
    return "" if filecmp.cmp(again, wheel, shallow=False) else f"{again.name} differs from {wheel}"


def _test_source(source: Path) -> str:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow", *SDIST_TESTS]
    run = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False, timeout=scaled(LIMIT_S))
    return "" if run.returncode == 0 else needs.last_line(run.stdout)


def _explain(run: subprocess.CompletedProcess[str]) -> str:
    """Return the problem of a command that failed."""
    return "" if run.returncode == 0 else f"exit status {run.returncode}: {needs.last_line(run.stderr or run.stdout)}"


def _expect(run: subprocess.CompletedProcess[str], text: str) -> str:
    return _explain(run) or ("" if text in run.stdout else f"no {text!r} in {run.stdout!r}")


def _expect_success(run: subprocess.CompletedProcess[str]) -> str:
    return _explain(run) or ("" if json.loads(run.stdout)["verified"] else run.stdout)


def _expect_error(run: subprocess.CompletedProcess[str], status: int, text: str) -> str:
    is_right = run.returncode == status and text in run.stderr and run.stderr.count("\n") == 1
    return "" if is_right else f"exit status {run.returncode}, {run.stderr!r}"


def _refuse_recording(new: Installation) -> str:
    run = new.call("robotcore", "run", "avoid-obstacles", "--record", "run.mcap")
    return _expect_error(run, 3, "pip install 'robotcore[record]'")


def _refuse_pybullet(new: Installation) -> str:
    run = new.call("robotcore", "run", "green-search", "--backend", "pybullet")
    return _expect_error(run, 3, "robotcore[sim]" if sys.version_info < (3, 12) else "Use --backend mujoco")


def _run_project(new: Installation) -> str:
    command = "run search.py --robot my_robot.toml --world room.toml --seed 7 --json"
    return _expect_success(new.call("robotcore", *command.split(), folder="my-robot"))


def _test_project(new: Installation) -> str:
    return _expect(new.call("python", "-m", "pytest", "-q", folder="my-robot"), "passed")


def _refuse_wheel(folder: Path, python: Path, wheel: Path) -> str:
    run = Installation(folder, str(python)).install(str(wheel))
    return "" if run.returncode and "requires a different Python" in run.stderr else run.stderr


def _refuse_python(folder: Path, python: Path, wheel: Path) -> str:
    forced = Installation(folder, str(python))
    installed = _explain(forced.install("--ignore-requires-python", "--no-deps", str(wheel)))
    return installed or _expect_error(forced.call("robotcore", "demo"), 2, "robotcore needs Python 3.10 or newer")


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("package", lambda: main(sys.argv[1:])))
