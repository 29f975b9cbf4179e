"""The import of lgpio, the header's chip, and the double of lgpio."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from drivers.raspberrypi import lg
from tests.drivers.raspberrypi.doctor.trees import create_chip
from tests.drivers.raspberrypi.lines import ROOT, Lines
from tests.drivers.raspberrypi.lines import lgpio as ours

needs_lgpio = pytest.mark.skipif(find_spec("lgpio") is None, reason="lgpio is not installed here")

LEAVING = """
import os
before = dict(os.environ)
from drivers.raspberrypi.lg import load
lgpio = load()
assert load() is lgpio
assert dict(os.environ) == before
print(os.getcwd())
"""

AT_ONCE = """
import os, tempfile, time
from concurrent.futures import ThreadPoolExecutor
from drivers.raspberrypi import lg
from tests.drivers.raspberrypi.doctor.trees import create_chip

class Slow(tempfile.TemporaryDirectory):
    def __init__(self, **options):
        time.sleep(0.5)
        super().__init__(**options)

lg.TemporaryDirectory = Slow
before = dict(os.environ)
with ThreadPoolExecutor(2) as pool:
    assert len(set(map(id, pool.map(lambda _: lg.load(), range(2))))) == 1
assert dict(os.environ) == before
"""


def run(code: str, folder: Path, environment: dict[str, str]) -> str:
    ran = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


@pytest.mark.parametrize("library", [pytest.param("real", marks=needs_lgpio), "ours"])
def test_importing_leaves_no_side_effects(library: str, tmp_path: Path) -> None:
    here, temporary = tmp_path / "here", tmp_path / "tmp"
    here.mkdir()
    temporary.mkdir()
    base = Lines(tmp_path / "dev").environment if library == "ours" else environment()
    printed = run(LEAVING, here, {**base, "TMPDIR": str(temporary)})
    assert Path(printed).samefile(here)
    assert not [*here.iterdir(), *temporary.iterdir()]


@pytest.mark.slow
def test_threads_can_import_at_the_same_time(tmp_path: Path) -> None:
    """The guardian opens the cutoffs of two motors in two threads, which import lgpio at the same time."""
    run(AT_ONCE, tmp_path, {**Lines(tmp_path / "dev").environment, "TMPDIR": str(tmp_path)})


@needs_lgpio
def test_the_configured_folder_of_the_fifo_is_used(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match=r"No such file or directory: .*missing"):
        run(LEAVING, tmp_path, environment(LG_WD=str(tmp_path / "missing")))


def test_pypi_s_empty_lgpio_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "lgpio", ModuleType("lgpio"))
    with pytest.raises(ImportError) as raised:
        lg.load()
    assert raised.value.args == (lg.STUB,)


@pytest.mark.parametrize(
    "revision, has_chip_4, number",
    [(0xA02082, True, 0), (0xC04170, False, 0), (0xC04170, True, 4)],
)
def test_the_header_is_on_chip_4_with_an_early_kernel_of_a_pi_5(
    revision: int, has_chip_4: bool, number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", lambda: revision)
    monkeypatch.setattr(Path, "exists", lambda file: has_chip_4 and file == Path("/dev/gpiochip4"))
    assert lg.find_chip_number(tmp_path) == number


@pytest.mark.parametrize(
    "chips, number",
    [
        ({0: "pinctrl-bcm2835", 1: "raspberrypi-exp-gpio"}, 0),
        ({0: "brcmstb-gpio", 3: "brcmstb-gpio", 4: "pinctrl-rp1"}, 4),
        ({0: "pinctrl-rp1", 4: "brcmstb-gpio"}, 0),
        ({11: "brcmstb-gpio", 15: "pinctrl-rp1"}, 15),
    ],
)
def test_the_header_s_chip_is_found_by_its_driver(chips: dict[int, str], number: int, tmp_path: Path) -> None:
    for each, driver in chips.items():
        create_chip(tmp_path, each, driver)
    assert lg.find_chip_number(tmp_path) == number


@needs_lgpio
def test_the_double_has_lgpio_s_functions(tmp_path: Path) -> None:
    """Import lgpio in another process, because lgpio's thread never ends."""
    run("from tests.drivers.raspberrypi.test_lg import compare; compare()", tmp_path, environment())


def compare() -> None:
    real = lg.load()
    for name in (name for name in vars(ours) if not name.startswith("_") and hasattr(real, name)):
        mine, theirs = getattr(ours, name), getattr(real, name)
        if inspect.isfunction(mine):
            assert parameters(mine) == parameters(theirs), name
        elif isinstance(mine, int):
            assert mine == theirs, name
    for status in (ours.CANNOT_OPEN_CHIP, ours.GPIO_BUSY):
        assert ours.error_text(status) == real.error_text(status)
    assert str(ours.error("GPIO busy")) == str(real.error("GPIO busy"))
    assert ours.error("GPIO busy").value == real.error("GPIO busy").value


def parameters(function: Any) -> list[tuple[str, Any]]:
    return [(each.name, each.default) for each in inspect.signature(function).parameters.values()]


def environment(**more: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), **more}
