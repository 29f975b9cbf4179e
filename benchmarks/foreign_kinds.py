"""Record and replay runs with kinds of devices of other packages, on each backend and with each generic fault.

    python -m benchmarks.foreign_kinds --runs 100 --seed 1

Each kind is one file of `benchmarks/kind_examples`, in a package that `robotcore new --kind` creates. The script
registers it as an installed package does. Each run is drawn from the seed: its kind, backend, world and fault. The app
puts each sample into its state, so the digest of a replay has all samples. The script also runs the conformance kit
with each kind in three simulators. The exit status is 1 if a replay or the kit fails.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.report import parse_options, print_table
from robotcore.cli.scaffold.template import KIND, make
from robotcore.sweep.engine import count_cores

ROOT = Path(__file__).parents[1]
APP = Path(__file__).with_name("sensor_reader.py")
BACKENDS = ("kinematic", "mujoco", "pybullet", "virtualpi", "mock")
TIMING = ("", "drop=0.3", "delay=0.2", "freeze after=1 lasts=0.5", "lost=1 after=2")
FAULTS = {
    "touch-plate": (*TIMING, "stuck=1 after=1", "spikes=0.1"),
    "gyro": (
        *TIMING,
        "noise=0.1 field=rate",
        "bias=0.05 field=rate",
        "stuck=0 field=angle after=1",
        "spikes=0.1 size=1 field=angle",
    ),
}
SUITE = """
from robotcore.hal.backend import load_backend
from robotcore.testing import ConformanceSuite

for each in ("kinematic", "mujoco", "pybullet"):
    names = {"backend": type(load_backend(each)), "robot": "robot.toml"}
    globals()[f"TestIn{each.title()}"] = type(f"TestIn{each.title()}", (ConformanceSuite,), names)
"""


class Case(NamedTuple):
    """A run, and its replay."""

    kind: str
    backend: str
    fault: str
    ticks: int
    problem: str
    """The output of the replay if it differs from the run, else an empty text."""


def main() -> int:
    """Run and replay on all cores, and print the results."""
    options = parse_options(__doc__, runs=100, seed=1)
    draw = Random(options.seed)
    with TemporaryDirectory() as name, ThreadPoolExecutor(count_cores()) as pool:
        folder = Path(name)
        for kind in FAULTS:
            _create_package(folder / kind)
        jobs = [partial(_replay_run, folder, Random(draw.random()), number) for number in range(options.runs)]
        cases = list(pool.map(lambda job: job(), jobs))
        suites = {kind: _run_suite(folder / kind) for kind in FAULTS}
    print_table(("kind", "backend", "runs", "faults", "ticks", "equal to the bit"), _build_rows(cases))
    print("".join(f"conformance kit, {kind}: {result}\n" for kind, result in suites.items()), end="")
    print("".join(f"differs: {case}\n" for case in cases if case.problem), end="")
    return int(any(case.problem for case in cases) or any("failed" in result for result in suites.values()))


def _create_package(folder: Path) -> None:
    """Create a package with a kind, and the metadata of an installed package."""
    make(KIND, folder)
    module = folder.name.replace("-", "_")
    (folder / f"{module}.py").write_text((Path(__file__).parent / "kind_examples" / f"{module}.py").read_text())
    (folder / "test_kit.py").write_text(SUITE)
    metadata = folder / f"{module}-0.1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {folder.name}\nVersion: 0.1\n")
    (metadata / "entry_points.txt").write_text(f"[robotcore.kinds]\n{module} = {module}:KIND\n")


def _replay_run(folder: Path, draw: Random, number: int) -> Case:
    kind, backend = draw.choice(sorted(FAULTS)), draw.choice(BACKENDS)
    fault = draw.choice(FAULTS[kind])
    file = folder / f"{number}.mcap"
    words = ["--robot", "robot.toml", "--world", draw.choice(("arena", "clutter")), "--backend", backend]
    words += ["--seed", str(draw.randrange(1000)), "--timeout", "4", "--record", str(file)]
    words += ["--fault", f"flow {fault}"] if fault else []
    result = json.loads(_call(folder / kind, "robotcore", "run", str(APP), *words, "--json").stdout)
    replayed = _call(folder / kind, "robotcore", "replay", str(file), "--app", str(APP))
    return Case(kind, backend, fault, result["ticks"], replayed.stderr if replayed.returncode else "")


def _run_suite(folder: Path) -> str:
    return _call(folder, "pytest", "-q", "-p", "no:cacheprovider", "test_kit.py").stdout.strip().rpartition("\n")[2]


def _call(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment: dict[str, Any] = {**os.environ, "PYTHONPATH": os.pathsep.join((str(folder), str(ROOT)))}
    return subprocess.run(  # noqa: S603  our own
        [sys.executable, "-m", *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def _build_rows(cases: list[Case]) -> Iterator[tuple[str, ...]]:
    for kind, backend in sorted({(case.kind, case.backend) for case in cases}):
        group = [case for case in cases if (case.kind, case.backend) == (kind, backend)]
        faults, ticks = sum(bool(case.fault) for case in group), sum(case.ticks for case in group)
        equal = sum(not case.problem for case in group)
        yield kind, backend, str(len(group)), str(faults), str(ticks), f"{equal}/{len(group)}"


if __name__ == "__main__":
    sys.exit(main())
