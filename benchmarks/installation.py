"""Measure the installation of the wheel in an empty environment, and the first demo: at most 60 s and 300 MB.

    python -m benchmarks.installation --repeats 3
    python -m benchmarks.installation --python python3.13 --warm 3

Each repetition makes a virtual environment, installs the wheel with an empty cache of pip, and runs ``robotcore demo``
on the built-in simulator. ``--warm`` is the number of repetitions with a full cache. The processor's time tells how
much of the duration other programs took. The size is that of the environment on the disk: whole blocks, with Python's
own copies of pip. The second table has the largest packages. The exit status is 1 if a bound is broken with an empty
cache.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from benchmarks.report import compute_median, parse_options, print_table

ROOT = Path(__file__).parents[1]
BOUND_S, BOUND_MB = 60.0, 300.0
LARGEST = 8
"""The number of packages in the table."""
BLOCK_BYTES = 512
"""The size of the blocks in which the system reports the size of a file."""


class Trial(NamedTuple):
    """An installation and its first demo."""

    install_s: float
    install_cpu_s: float
    demo_s: float
    size_mb: float
    empty_mb: float
    """The size of the environment before the installation, in MB."""


def main() -> int:
    """Measure each repetition, and print the medians."""
    options = parse_options(__doc__, repeats=3, warm=0, python=sys.executable)
    with TemporaryDirectory(prefix="robotcore-installation-") as scratch:
        folder = Path(scratch)
        wheel = _build_wheel(folder)
        cold = [
            _try(folder / f"cold-{number}", options.python, wheel, folder / f"cache-{number}")
            for number in range(options.repeats)
        ]
        warm = [
            _try(folder / f"warm-{number}", options.python, wheel, folder / "cache-0") for number in range(options.warm)
        ]
        packages = _list_packages(folder / "cold-0")
    is_within = _print_trials(cold, warm)
    print()
    print_table(("package", "MB"), [(name, f"{size:.0f}") for name, size in packages])
    return int(not is_within)


def _build_wheel(folder: Path) -> Path:
    command = [sys.executable, "-m", "build", "--wheel", "--outdir", str(folder / "dist"), str(ROOT)]
    subprocess.run(command, check=True, capture_output=True)  # noqa: S603  our own
    (wheel,) = folder.glob("dist/*.whl")
    return wheel


def _try(folder: Path, python: str, wheel: Path, cache: Path) -> Trial:
    """Install the wheel into a new environment, and run the demo there."""
    environment = folder / "environment"
    _time_s([python, "-m", "venv", str(environment)], ROOT, cache)
    empty = _measure_mb(environment)
    install = [str(environment / "bin" / "python"), "-m", "pip", "install", "--quiet", str(wheel)]
    before = _read_cpu_s()
    install_s = _time_s(install, folder, cache)
    install_cpu_s = _read_cpu_s() - before
    demo_s = _time_s([str(environment / "bin" / "robotcore"), "demo"], folder, cache)
    return Trial(install_s, install_cpu_s, demo_s, _measure_mb(environment), empty)


def _read_cpu_s() -> float:
    """Return the processor's time of all ended child processes, in seconds."""
    times = os.times()
    return times.children_user + times.children_system


def _time_s(command: list[str], folder: Path, cache: Path) -> float:
    environment = {**os.environ, "PIP_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": ""}
    environment.pop("PYTHONPATH", None)
    folder.mkdir(exist_ok=True)
    start = perf_counter()
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)  # noqa: S603  our own
    return perf_counter() - start


def _measure_mb(*paths: Path) -> float:
    files = [file for path in paths for file in (path.rglob("*") if path.is_dir() else [path]) if not file.is_symlink()]
    return sum(file.lstat().st_blocks * BLOCK_BYTES for file in files) / 1e6


def _list_packages(folder: Path) -> list[tuple[str, float]]:
    """Return the largest folders of installed packages with their sizes in MB. ``NAME.libs`` belongs to a package."""
    (site,) = folder.glob("environment/lib/python3*/site-packages")
    sizes = Counter[str]()
    for each in site.iterdir():
        name = each.name.partition(".libs")[0].partition("-")[0]
        sizes["cv2 (OpenCV)" if name in ("cv2", "opencv_python_headless") else name] += round(_measure_mb(each) * 1e6)
    return [(name, size / 1e6) for name, size in sizes.most_common(LARGEST)]


def _print_trials(cold: list[Trial], warm: list[Trial]) -> bool:
    """Print the medians, and return whether those with an empty cache are within the bounds."""
    rows = []
    for kind, trials in (("empty", cold), ("full", warm)):
        values = {
            "installation": [each.install_s for each in trials],
            "of it the processor's time": [each.install_cpu_s for each in trials],
            "first demo": [each.demo_s for each in trials],
            f"together, at most {BOUND_S:g}": [each.install_s + each.demo_s for each in trials],
        }
        rows += [
            (f"{name}, {kind} cache, s", *compute_median(seconds).format_cells(".1f"))
            for name, seconds in values.items()
            if seconds
        ]
    size = compute_median(each.size_mb for each in cold)
    rows.append((f"environment, at most {BOUND_MB:g}, MB", *size.format_cells(".0f")))
    rows.append(
        ("of it before the installation, MB", *compute_median(each.empty_mb for each in cold).format_cells(".0f"))
    )
    print_table((f"{len(cold) + len(warm)} environments", "median", "95 % interval"), rows)
    total = compute_median(each.install_s + each.demo_s for each in cold)
    return total.median <= BOUND_S and size.median <= BOUND_MB


if __name__ == "__main__":
    sys.exit(main())
