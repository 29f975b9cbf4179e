from __future__ import annotations

import re
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from docs.generator.notebook_pages import FOLDER, read_notebook, run_notebook
from tests.kernels import CellOutputs
from tests.kernels import kernel_folder as kernel_folder  # noqa: PLC0414  a fixture

pytestmark = pytest.mark.timeout(300)
"""A busy machine takes several times as long."""

NAMES = sorted(file.stem for file in FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("name", NAMES)
def test_notebook_in_git_has_no_outputs(name: str) -> None:
    for cell in read_notebook(name).cells:
        assert cell.cell_type == "markdown" or (cell.outputs, cell.execution_count) == ([], None), cell.id


@pytest.mark.parametrize("name", NAMES)
def test_links_of_a_notebook_exist(name: str) -> None:
    text = "\n".join(cell.source for cell in read_notebook(name).cells if cell.cell_type == "markdown")
    links = re.findall(r"\]\(([^)#]*)(?:#[^)]*)?\)", text)
    assert links
    for link in links:
        assert (FOLDER / link).exists(), link


def run_cells(name: str, folder: Path) -> dict[str, CellOutputs]:
    """Run a notebook, and return the outputs of each code cell by its id."""
    cells = run_notebook(name, folder).cells
    return {cell.id: CellOutputs(cell.outputs) for cell in cells if cell.cell_type == "code"}


@pytest.fixture
def folder(kernel_folder: Path) -> Path:
    """Copy the files beside the notebooks into the kernel's folder."""
    for file in FOLDER.glob("*.py"):
        shutil.copy(file, kernel_folder)
    return kernel_folder


@pytest.mark.slow
def test_first_drive(folder: Path) -> None:
    cells = run_cells("first-drive", folder)
    assert [each for each in cells if cells[each].has_picture] == ["show", "show-path", "frame", "arena", "show-arena"]
    assert [each for each in cells if cells[each].errors] == ["blocked", "interrupt"]
    assert cells["straight"].number == pytest.approx(0.5, abs=0.01)
    assert "heading=1.57" in cells["turn"].text
    assert 0 <= cells["closing-error"].number < 10
    assert "contacts=0" in cells["truth"].text
    assert cells["wait"].number == pytest.approx(cells["clock"].number + 2.0)
    assert "closed" in cells["close"].text
    assert cells["blocked"].errors == ["BlockedError"]
    assert "Turn round" in cells["catch"].text
    assert cells["interrupt"].errors == ["KeyboardInterrupt"]
    assert 0 < cells["stopped"].number < 1.5
    assert cells["drive-on"].number == pytest.approx(cells["stopped"].number + 0.1, abs=0.05)
    assert cells["script"].number == pytest.approx(0.2, abs=0.01)


@pytest.mark.slow
def test_find_the_ball(folder: Path) -> None:
    cells = run_cells("find-the-ball", folder)
    assert [each for each in cells if cells[each].has_picture] == ["open", "marked", "show-end"]
    assert cells["detector"].text == "[]"
    assert cells["search"].text == "True"
    assert cells["bearing"].number > 0.3
    assert abs(cells["faced"].number) < 0.1
    assert 0.2 < cells["approach"].number < 0.3
    assert 0.2 < cells["truth"].number < 0.35
    assert "0 contacts" in cells["truth"].text
    assert "class FindBall" in cells["file"].text
    assert "SUCCESS" in cells["run-live"].text
    assert cells["verified"].text == "True"
    assert re.fullmatch(r"\{'seen': [\d.]+, 'near': [\d.]+\}", cells["milestones"].text)
    for each in ("run", "seed", "setting"):
        assert "on kinematic: success" in cells[each].text
    assert "8/8" in cells["sweep"].text


@pytest.mark.slow
def test_from_simulation_to_robot(folder: Path) -> None:
    cells = run_cells("from-simulation-to-robot", folder)
    assert "on kinematic: success" in cells["import"].text
    installed = ["kinematic", *(each for each in ("mujoco", "pybullet") if find_spec(each))]
    simulators = re.findall(r"(?m)^(\w+): success, 0.2\d m from the ball$", cells["simulators"].text)
    assert simulators == installed
    assert "success, verified: True" in cells["faults"].text
    assert "stopped\neye: the newest sample is" in cells["frozen"].text
    assert "verified by the simulator" in cells["record"].text
    assert [each for each in cells if cells[each].has_picture] == ["picture"]
    assert cells["replay"].text.startswith("bit-equal")
    assert "[raspberrypi] OK" in cells["check"].text
    assert "GPIO 17" in cells["wiring"].text
    assert "success, 0.2" in cells["virtualpi"].text
    assert cells["prompt"].number == pytest.approx(0.5, abs=0.01)
