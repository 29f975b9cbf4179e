"""A robot in a Jupyter kernel: completion, pictures, errors, interrupts, and the end of the kernel."""

from __future__ import annotations

import pytest

from tests.kernels import Kernel
from tests.kernels import kernel as kernel  # noqa: PLC0414  a fixture
from tests.kernels import kernel_folder as kernel_folder  # noqa: PLC0414  a fixture

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

OPEN = "import robotcore\nrobot = robotcore.open('rover', world='arena')"

DRIVE = """
from robotcore import parallel, straight, wait

def report():
    yield from wait(robot, 0.5)
    print("it drives")

robot.run(parallel(straight(robot, 5.0), report()))
"""


def test_tab_completes_the_names_of_calls_and_devices(kernel: Kernel) -> None:
    kernel.run(OPEN)
    assert {"camera", "drive", "map", "range", "run", "show", "wait"} <= {*kernel.complete("robot.")}
    assert {"arc", "pose", "straight", "turn"} <= {*kernel.complete("robot.drive.")}
    assert {"eye", "left_encoder", "nose"} <= {*kernel.complete('robot["')}


def test_results_of_cells_are_pictures_and_short_tracebacks(kernel: Kernel) -> None:
    kernel.run(OPEN)
    for shown in ("robot.camera.read()", "robot.map", "robot.show()"):
        assert kernel.run(shown).has_picture, shown
    assert kernel.run("robot.drive").text.startswith("<DifferentialDrive")
    for wrong in (
        "robot.drive.straight(3.0)",
        "robotcore.open(world='nowhere')",
        "robotcore.open(faults='range melt')",
    ):
        cell = kernel.run(wrong)
        assert len(cell.errors) == 1
        assert len([line for line in cell.traceback if line.startswith("File ")]) <= 2, cell.traceback


def test_interrupt_ends_the_cell_and_the_robot_stays_open(kernel: Kernel) -> None:
    kernel.run("import robotcore\nrobot = robotcore.open('rover', world='open', realtime=True)")
    assert kernel.run(DRIVE, interrupt_after="it drives").errors == ["KeyboardInterrupt"]
    stopped = kernel.run("print(robot.drive.pose.x)").number
    assert 0 < stopped < 2
    assert not kernel.run("robot.wait(0.2)").errors
    assert kernel.run("print(robot.drive.pose.x)").number == pytest.approx(stopped, abs=0.05)
    assert kernel.run("print(robot.drive.straight(0.1).x)").number == pytest.approx(stopped + 0.1, abs=0.06)


def test_cell_that_opens_the_robot_runs_again(kernel: Kernel) -> None:
    kernel.run("import threading, robotcore")
    for backend in ("kinematic", "virtualpi"):
        threads = []
        for _ in range(4):
            kernel.run(f"robot = robotcore.open('rover', '{backend}', world='open')")
            assert kernel.run("robot.drive.straight(0.1)").number == pytest.approx(0.1, abs=0.01)
            threads.append(int(kernel.run("threading.active_count()").text))
        assert threads[-1] == threads[-2]
