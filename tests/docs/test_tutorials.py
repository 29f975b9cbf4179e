"""Run the commands and listings of both tutorials, with doubles of the simulators."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from robotcore.hal.wall_clock import MonotonicClock
from tests.docs.listings import ConsoleCommand, list_commands, list_listings, write_files
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import VisionSensor
from tests.doubles.coppeliasim.scenes import bubblerob_scene, relay_scene
from tests.texts import CheckText

DOCS = Path(__file__).parents[2] / "docs"
SCENES = {"bubblerob": bubblerob_scene, "green-relay": relay_scene}
PAGES = {name: (DOCS / "tutorials" / f"{name}.md").read_text(encoding="utf-8") for name in SCENES}
ROBOTS = Path(__file__).parents[2] / "robotcore" / "description" / "robots"
PORTS = {"vrep": 19997, "coppeliasim": 23000}
YELLOW = (255, 255, 0)
PATIENCE_S = 10.0

TYPED = [(name, each) for name, page in PAGES.items() for each in list_commands(page)]
CONSOLE_COMMANDS = [
    pytest.param(page, each, id=each.command) for page, each in TYPED if each.command.startswith("robotcore ")
]
(OLD_REFLEX,) = (each for _, each in TYPED if each.command == "python old_reflex.py")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write the files of both pages into a folder, and make it the current folder."""
    for page in PAGES.values():
        write_files(list_listings(page), tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def simulator(request: pytest.FixtureRequest) -> Simulator:
    return SCENES[request.param]()


@pytest.fixture
def double(simulator: Simulator) -> Iterator[Double]:
    with Double(simulator) as double:
        yield double


def replace_port(double: Double, text: str) -> str:
    """Replace the simulator's default port by the double's port."""
    return text.replace(str(PORTS["vrep"]), str(double.legacy_port))


def parse_arguments(command: str, double: Double) -> list[str]:
    """Return the arguments of a ``robotcore`` command that uses the double as its simulator."""
    words = shlex.split(replace_port(double, command))[1:]
    return [*words, "--port", str(double.zmq_port)] if "coppeliasim" in words else words


@contextmanager
def run_old_script(folder: Path, double: Double, name: str) -> Iterator[subprocess.Popen[str]]:
    """Run a script of a page, with the double as its simulator."""
    script = folder / name
    script.write_text(replace_port(double, script.read_text(encoding="utf-8")), encoding="utf-8")
    command = [sys.executable, str(script)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.slow
@pytest.mark.parametrize("simulator, command", CONSOLE_COMMANDS, indirect=["simulator"])
def test_command_prints_the_output_on_the_page(
    double: Double, command: ConsoleCommand, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    execute(parse_arguments(command.command, double))
    answer = "".join(capfd.readouterr())
    assert command.matches(answer), answer


@pytest.mark.slow
@pytest.mark.parametrize("simulator", ["bubblerob"], indirect=True)
def test_old_reflex_prints_the_output_on_the_page(double: Double, folder: Path) -> None:
    with run_old_script(folder, double, "old_reflex.py") as script:
        answer, _ = script.communicate(timeout=PATIENCE_S)
    assert OLD_REFLEX.matches(answer), answer


@pytest.mark.slow
@pytest.mark.parametrize("simulator", ["green-relay"], indirect=True)
def test_old_relay_marks_the_ball_until_the_simulator_ends(double: Double, simulator: Simulator, folder: Path) -> None:
    with simulator.lock:
        simulator.start()
    with run_old_script(folder, double, "old_relay.py") as script:
        await_yellow(simulator)
        double.legacy.close()
        assert script.wait(PATIENCE_S) == 0, script.communicate()


def await_yellow(simulator: Simulator) -> None:
    """Wait until the second vision sensor shows a yellow line."""
    screen = next(each for each in simulator.graph.all_of(VisionSensor) if each.alias == "v1")
    clock = MonotonicClock()
    while not (simulator.picture(screen) == YELLOW).all(axis=2).any():
        assert clock.now() < PATIENCE_S
        clock.sleep_until(clock.now() + 0.05)


def test_wiring_of_a_real_bubblerob_is_complete(
    folder: Path, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    (wiring,) = (each.text for each in list_listings(PAGES["bubblerob"]) if "[raspberrypi." in each.text)
    shipped = (ROBOTS / "bubblerob.toml").read_text(encoding="utf-8")
    (folder / "my_bubblerob.toml").write_text(shipped + wiring, encoding="utf-8")
    assert execute(["check", "my_bubblerob.toml"]) == 0
    (line,) = (line for line in capfd.readouterr().out.splitlines() if "[raspberrypi]" in line)
    check_text(line)


def test_mark_equals_mark_green() -> None:
    (listing,) = (each.text for each in list_listings(PAGES["green-relay"]) if each.file == "mark.py")
    shipped = (Path(__file__).parents[2] / "apps" / "mark_green.py").read_text(encoding="utf-8")
    assert listing.partition("def step")[2] == shipped.partition("def step")[2].partition("\n\n\n")[0] + "\n"
