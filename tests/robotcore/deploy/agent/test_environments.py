"""Environments of the real venv and the real pip, with wheels that the tests build, and explanations of errors."""

from __future__ import annotations

import errno
import json
import os
import platform
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest

from robotcore.deploy.agent import environments, files
from robotcore.deploy.agent.environments import EnvironmentSpec, explain_failure
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD
from tests.texts import CheckText, Raises

WIDGET = "robot_widget"


def write_wheel(folder: Path, name: str, version: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    info = f"{name}-{version}.dist-info"
    file = folder / f"{name}-{version}-py3-none-any.whl"
    with ZipFile(file, "w") as wheel:
        wheel.writestr(f"{name}.py", f"VERSION = '{version}'\n")
        wheel.writestr(f"{info}/METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        wheel.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        wheel.writestr(f"{info}/RECORD", f"{name}.py,,\n{info}/METADATA,,\n{info}/WHEEL,,\n{info}/RECORD,,\n")
    return file


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Layout:
    """A robot with one environment, which has the package widget."""
    layout = Layout(tmp_path_factory.mktemp("home with 'quotes' and ü"))
    write_wheel(layout.root / "wheels", WIDGET, "1.0")
    with pytest.MonkeyPatch.context() as here:
        here.setattr(os, "sync", lambda: None)
        environments.create_environment(
            layout,
            EnvironmentSpec.from_requirements([f"{WIDGET}>=1"]),
            OLD,
            environments.PipInputs(wheels=layout.root / "wheels"),
        )
    return layout


@pytest.fixture
def environment(robot: Layout) -> Iterator[Path]:
    """That environment, restored after the test."""
    folder = next(robot.environments.iterdir())
    contents = folder.joinpath(environments.COMPLETE_FILE).read_text()
    yield folder
    folder.joinpath(environments.COMPLETE_FILE).write_text(contents)


@pytest.fixture(autouse=True)
def _remove_pip_options(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (name for name in os.environ if name.startswith("PIP_")):
        monkeypatch.delenv(name)


@pytest.mark.slow
def test_environment_has_its_requirements_and_is_found_by_them(robot: Layout, environment: Path) -> None:
    command = [str(environment / "bin" / "python"), "-c", "import robot_widget; print(robot_widget.VERSION)"]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "1.0\n"
    assert (
        environments.find_environment(robot, EnvironmentSpec.from_requirements([f" {WIDGET}>=1 ", f"{WIDGET}>=1"]))
        == environment
    )
    assert environments.find_environment(robot, EnvironmentSpec.from_requirements([f"{WIDGET}>=2"])) is None
    requirements = EnvironmentSpec.from_requirements([f"{WIDGET}>=1"]).requirements
    assert environments.find_environment(robot, EnvironmentSpec(requirements, "cpython-399 aarch64")) is None


@pytest.mark.slow
@pytest.mark.parametrize("version, is_fit", [(pytest.__version__, True), ("0.1", False), (None, False)])
def test_incomplete_environment_and_one_for_another_system_package_are_not_used(
    robot: Layout, environment: Path, version: str | None, *, is_fit: bool
) -> None:
    file = environment / environments.COMPLETE_FILE
    contents = json.dumps({**json.loads(file.read_text()), "leans_on": {"pytest": version}})
    file.write_text(contents if version else contents[:-20])
    found = environments.find_environment(robot, EnvironmentSpec.from_requirements([f"{WIDGET}>=1"]))
    assert found == (environment if is_fit else None)


@pytest.mark.slow
def test_system_packages_are_returned_without_those_of_the_release(environment: Path, tmp_path: Path) -> None:
    system, site = tmp_path / "dist-packages", tmp_path / "site"
    for name, folder in (("apt_gadget", system), ("brought_gadget", site)):
        with ZipFile(write_wheel(tmp_path, name, "3.0")) as wheel:
            wheel.extractall(folder)
    packages = next(environment.glob("lib/python*/site-packages"))
    (packages / "system.pth").write_text(f"{system}\n")
    requirements = ["apt_gadget", "brought_gadget", WIDGET]
    assert environments.install_requirements(environment, requirements, environments.PipInputs(tmp_path, site)) == {
        "apt_gadget"
    }


@pytest.mark.slow
def test_unreachable_address_is_a_network_error_without_its_password(
    environment: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(AgentError) as refused:
        environments.install_requirements(
            environment,
            ["gadget @ http://user:secret@127.0.0.1:9/gadget-1.0-py3-none-any.whl"],
            environments.PipInputs(),
        )
    assert refused.value.kind == "network"
    assert "Collecting gadget" in (output := capsys.readouterr().out)
    assert "secret" not in output + str(refused.value)


@pytest.mark.slow
def test_requirement_that_looks_like_an_option_is_refused(environment: Path, tmp_path: Path, raises: Raises) -> None:
    canary = tmp_path / "canary"
    with raises(AgentError, "requirement"):
        environments.install_requirements(environment, [f"--target={canary}"], environments.PipInputs(tmp_path))
    assert not canary.exists()


@pytest.mark.slow
def test_pip_is_killed_if_the_report_raises(environment: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail_to_report(text: str) -> None:
        raise BrokenPipeError

    monkeypatch.setenv("PIP_DEFAULT_TIMEOUT", "600")
    monkeypatch.setattr(environments, "report_progress", fail_to_report)

    with socket.create_server(("127.0.0.1", 0)) as silent:
        place = f"http://127.0.0.1:{silent.getsockname()[1]}/gadget-1.0-py3-none-any.whl"
        with pytest.raises(BrokenPipeError):
            environments.install_requirements(environment, [f"gadget @ {place}"], environments.PipInputs())
    left = [path for path in Path("/proc").glob("[0-9]*/cwd") if _is_link_to(path, environment)]
    assert left == []


def test_failed_environment_is_deleted(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(files, "write_file", full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
        environments.create_environment(layout, EnvironmentSpec.from_requirements([]), NEW, environments.PipInputs())
    assert not any(layout.environments.iterdir())


def _is_link_to(link: Path, folder: Path) -> bool:
    try:
        return link.readlink() == folder
    except OSError:
        return False


NOT_FOUND = """\
ERROR: Could not find a version that satisfies the requirement six==99 (from versions: 1.16.0, 1.17.0)
ERROR: No matching distribution found for six==99
"""
UNREACHABLE = """\
WARNING: Retrying (Retry(total=0, connect=None, read=None, redirect=None, status=None)) after connection broken by \
'NewConnectionError('<pip._vendor.urllib3.connection.HTTPSConnection object at 0x7f9b030513d0>: Failed to establish a \
new connection: [Errno -2] Name or service not known')': /simple/six/
ERROR: Could not find a version that satisfies the requirement six (from versions: none)
ERROR: No matching distribution found for six
"""
UNTRUSTED = """\
Could not fetch URL https://index.example/simple/six/: There was a problem confirming the ssl certificate: \
HTTPSConnectionPool(host='index.example', port=443): Max retries exceeded with url: /simple/six/ (Caused by \
SSLError(SSLCertVerificationError(1, '[SSL: CERTIFICATE_VERIFY_FAILED] certificate verify failed: {why} \
(_ssl.c:992)'))) - skipping
ERROR: No matching distribution found for six
"""
CONTRADICTORY = """\
ERROR: Cannot install six==1.15 and six==1.16 because these package versions have conflicting dependencies.
ERROR: ResolutionImpossible: for help visit the documentation
"""
FULL = """\
Installing collected packages: numpy
ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device
"""
UNBUILT = """\
Collecting six
Collecting lgpio==0.2.2.0
  Running setup.py install for lgpio: finished with status 'error'
  error: subprocess-exited-with-error
  \u00d7 Running setup.py install for lgpio did not run successfully.
  \u2570\u2500> [10 lines of output]
      swig -python -o lgpio_wrap.c lgpio.i
      error: command 'swig' failed: No such file or directory
      [end of output]
error: legacy-install-failure
\u2570\u2500> lgpio
"""
HERE = (platform.python_version(), platform.machine())


@pytest.mark.parametrize(
    "printed, kind",
    [
        pytest.param(NOT_FOUND, "requirement", id="not found"),
        pytest.param(NOT_FOUND, "wheels of upload", id="not uploaded"),
        pytest.param(UNREACHABLE, "network", id="unreachable"),
        pytest.param(UNTRUSTED.format(why="certificate is not yet valid"), "network", id="certificate out of date"),
        pytest.param(UNTRUSTED.format(why="self-signed certificate"), "network", id="certificate untrusted"),
        pytest.param(CONTRADICTORY, "requirement", id="contradictory"),
        pytest.param(FULL, "disk", id="disk full"),
        pytest.param(UNBUILT, "wheels", id="not built"),
        pytest.param("ERROR: Invalid requirement: 'six =='\n", "requirement", id="invalid"),
        pytest.param("Collecting six\nERROR: something new\n", "pip", id="unknown error"),
    ],
)
def test_each_failure_is_explained(printed: str, kind: str, check_text: CheckText) -> None:
    error = explain_failure(printed.splitlines(), is_offline=kind == "wheels of upload")
    assert error.kind == kind.partition(" ")[0]
    check_text(error, hide=HERE)
