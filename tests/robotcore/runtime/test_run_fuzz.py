"""Each robot and world that can be read can be run. The run ends, or raises an error with a remedy."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from robotcore import RunRequest, run
from robotcore.errors import UsageError

SHIPPED = resources.files("robotcore.description")
ROBOT = SHIPPED.joinpath("robots", "rover.toml").read_text(encoding="utf-8")
WORLDS = [SHIPPED.joinpath("worlds", f"{name}.toml").read_text(encoding="utf-8") for name in ("arena", "open")]
NUMBER = re.compile(r"(?<=[= \[])-?\d+(?:\.\d+)?(?=[,\] \n])")
NUMBERS = ["0", "1e-300", "1e-9", "0.001", "0.5", "1", "3.14", "16", "100.0", "1000", "1e6", "1e300", "-1", "-0.5"]


@st.composite
def other_numbers(draw: st.DrawFn, texts: st.SearchStrategy[str]) -> str:
    """Return a description with up to three changed numbers."""
    text = draw(texts)
    for _ in range(draw(st.integers(0, 3))):
        found = draw(st.sampled_from(list(NUMBER.finditer(text))))
        scaled = f"{float(found[0]) * draw(st.sampled_from([0.1, 0.9, 1.1, 3.0, -1.0]))!r}"
        text = text[: found.start()] + draw(st.sampled_from([scaled, *NUMBERS])) + text[found.end() :]
    return text


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mock", "pybullet"])
@settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    robot=other_numbers(st.just(ROBOT)),
    world=other_numbers(st.sampled_from(WORLDS)),
    seed=st.one_of(st.none(), st.integers(0, 9)),
    app=st.sampled_from(["avoid-obstacles", "green-search"]),
)
@example(robot=ROBOT.replace("1.0821", "1e-300"), world=WORLDS[0], seed=None, app="green-search")
def test_readable_descriptions_can_be_run(
    tmp_path: Path, backend: str, robot: str, world: str, seed: int | None, app: str
) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    files = tmp_path / "robot.toml", tmp_path / "world.toml"
    for file, text in zip(files, (robot, world), strict=True):
        file.write_text(text)
    try:
        result = run(RunRequest(app, backend, str(files[0]), str(files[1]), seed=seed, timeout_s=0.15))
    except UsageError:
        return
    assert result.error is None, result.reason
