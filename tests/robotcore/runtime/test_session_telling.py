from __future__ import annotations

import json

from robotcore.errors import DeviceError
from robotcore.runtime.behaviour import Status
from robotcore.runtime.session import RunRequest, RunResult
from tests.robotcore.fakes import RigBackend
from tests.robotcore.runs import Runner, Watcher, raising, then


def test_observers_hear_the_run_each_tick_and_the_result(perform: Runner) -> None:
    watcher = Watcher()
    result = perform(then(lambda _: Status.SUCCESS), observers=[watcher])
    assert [name for name, _ in watcher.heard] == ["begin", "tick", "tick", "tick", "end"]
    assert watcher.heard[-1][1] is result
    assert [record.tick for name, record in watcher.heard if name == "tick"] == [0, 1, 2]


def test_the_end_is_told_even_where_the_run_failed(perform: Runner) -> None:
    watcher = Watcher()
    perform(raising(DeviceError("eye", "no picture")), observers=[watcher])
    assert watcher.heard[-1][0] == "end"


def test_names_and_numbers_of_the_request_are_in_the_result(perform: Runner) -> None:
    result = perform(then(lambda _: Status.SUCCESS), RunRequest("an_app", seed=4))
    assert (result.app, result.backend, result.robot, result.world, result.seed) == (
        "an-app",
        "rig",
        "rover",
        None,
        4,
    )


def test_milestones_interventions_and_digest_are_those_of_the_trace(perform: Runner, backend: RigBackend) -> None:
    app = then(lambda _: Status.SUCCESS)
    app.milestones = ("start", "never")  # type: ignore[misc]
    backend._prepare = lambda rig: setattr(rig.nose, "distance", 0.05)
    first, second = perform(app), perform(then(lambda _: Status.SUCCESS))
    assert (first.milestones, first.interventions) == ({"start": 0.0}, 3)
    assert first.trace_sha256 == second.trace_sha256


def test_the_line_of_json_tells_everything_but_the_exception(perform: Runner) -> None:
    told = json.loads(perform(raising(DeviceError("eye", "no picture"))).to_json())
    assert told["outcome"] == "error"
    assert "error" not in told
    assert set(told) == set(RunResult.__dataclass_fields__) - {"error"}
