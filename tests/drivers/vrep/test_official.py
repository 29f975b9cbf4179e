"""Tests of loading the official binding, of the errors for an incomplete one, and of runs over it."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from drivers.vrep import simx
from drivers.vrep.official_binding import LIBRARIES, load_binding
from drivers.vrep.wire.errors import NoServerError
from robotcore.errors import BackendMissingError
from robotcore.runtime.result import Outcome, RunResult
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import relay_scene
from tests.drivers.vrep.test_apps import create_arena, run_on
from tests.texts import Raises

LIBRARY = LIBRARIES.get(sys.platform, "remoteApi.so")
CONSTANTS = "simx_opmode_blocking = 0x010000\n"
MODULE = "from {constants} import *\nprint('The remoteApi library could not be loaded')\ndef simxStart(*_): return 7\n"


@pytest.fixture
def library() -> Path:
    """Return a library of this system that can be loaded."""
    import _ctypes

    return Path(_ctypes.__file__)


def create_folder(folder: Path, library: Path, module: str = "sim", text: str = MODULE) -> Path:
    constants = {"sim": "simConst", "vrep": "vrepConst"}[module]
    folder.mkdir(exist_ok=True)
    (folder / f"{module}.py").write_text(text.format(constants=constants))
    (folder / f"{constants}.py").write_text(CONSTANTS)
    shutil.copy(library, folder / LIBRARY)
    return folder


@pytest.mark.parametrize("module", ["sim", "vrep"])
def test_binding_is_loaded_from_its_folder_or_file(
    module: str, tmp_path: Path, library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = create_folder(tmp_path, library, module)
    for path in (folder, folder / f"{module}.py", str(folder / LIBRARY)):
        binding = load_binding(path)
        assert (binding.simxStart(), binding.simx_opmode_blocking) == (7, 0x010000)
    assert capsys.readouterr().out == ""
    assert str(folder) not in sys.path
    assert f"{module}Const" not in sys.modules


def test_constants_come_from_the_same_folder(tmp_path: Path, library: Path) -> None:
    load_binding(create_folder(tmp_path / "one", library))
    other = create_folder(tmp_path / "other", library)
    (other / "simConst.py").write_text("simx_opmode_blocking = 5\n")
    assert load_binding(other).simx_opmode_blocking == 5


@pytest.mark.parametrize("missing", ["sim.py", "simConst.py", LIBRARY])
def test_missing_file_is_an_error(missing: str, tmp_path: Path, library: Path, raises: Raises) -> None:
    (create_folder(tmp_path, library) / missing).unlink()
    with raises(BackendMissingError, "binding-incomplete"):
        load_binding(tmp_path)


def test_library_of_another_system_is_an_error(tmp_path: Path, library: Path) -> None:
    (create_folder(tmp_path, library) / LIBRARY).write_bytes(b"MZ not for here")
    with pytest.raises(BackendMissingError) as caught:  # the text has the system's own reason
        load_binding(tmp_path)
    assert caught.value.kind == "binding-library"


@pytest.mark.parametrize("text", ["print 'Python 2'\n", "x = 1\n"], ids=["python 2", "no function"])
def test_module_that_is_not_a_binding_is_an_error(text: str, tmp_path: Path, library: Path) -> None:
    with pytest.raises(BackendMissingError) as caught:  # the text has Python's own reason
        load_binding(create_folder(tmp_path, library, text=text))
    assert caught.value.kind == "binding-import"


@pytest.fixture(autouse=True)
def _use_own_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.vrep.official_binding.load_binding", lambda _path: simx)


def run_over_binding(simulator: Simulator, app: str, *, stepped: bool = True, duration_s: float = 0.5) -> RunResult:
    options = {"binding": "/opt/vrep", "stepped": stepped}
    return run_on(simulator, app, settings={"duration_s": duration_s}, options=options)


@pytest.mark.parametrize("stepped", [True, False])
@pytest.mark.parametrize("app", ["avoid-obstacles", "mark-green"])
def test_apps_run_over_a_binding_and_stop_the_simulation(app: str, *, stepped: bool) -> None:
    simulator = relay_scene() if app == "mark-green" else create_arena("rover", 3)
    result = run_over_binding(simulator, app, stepped=stepped)
    assert result.outcome is Outcome.SUCCESS, result.reason
    assert simulator.state is State.STOPPED


def test_step_over_a_binding_is_one_time_step() -> None:
    result = run_over_binding(create_arena("rover", 3), "avoid-obstacles", duration_s=1.0)
    assert (result.ticks, result.sim_time_s) == (21, 1.0)


def test_address_without_a_server_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simx, "simxStart", lambda *_: -1)
    result = run_over_binding(create_arena("rover", 3), "avoid-obstacles")
    assert (result.exit_status, type(result.error)) == (3, NoServerError)


def test_folder_without_a_binding_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    result = run_over_binding(create_arena("rover", 3), "avoid-obstacles")
    assert isinstance(result.error, BackendMissingError)
    assert (result.exit_status, result.error.kind) == (3, "binding-incomplete")
