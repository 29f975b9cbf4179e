"""A run's end in a few lines."""

from __future__ import annotations

from collections.abc import Iterator

from rich.text import Text

from robotcore.errors import RobotcoreError
from robotcore.runtime.faults.spec import Spec
from robotcore.runtime.outcome import Outcome, RunResult
from robotcore.text import counted, escape

_STYLES = {Outcome.SUCCESS: "bold green", Outcome.INTERRUPTED: "bold yellow", Outcome.TIMEOUT: "bold yellow"}
_BAD = "bold red"


def summary(result: RunResult) -> Text:
    """Return the outcome, what it was measured by, the milestones and the reason, a line each."""
    style = _BAD if result.dispute else _STYLES.get(result.outcome, _BAD)
    outcome = Text(result.outcome.value, style)
    lines = [", ".join(measures(result)), *events(result)]
    if result.reason and not isinstance(result.error, RobotcoreError):
        lines.append(result.reason)
    first = outcome + Text(f"  {escape(heading(result))}")
    return Text("\n").join([first, *(Text(f"  {escape(line)}") for line in lines)])


def heading(result: RunResult) -> str:
    """Return what ran on what: ``green-search on kinematic, arena, seed 7``."""
    place = [result.world] if result.world else []
    seed = [f"seed {result.seed}"] if result.seed is not None else []
    return ", ".join([f"{result.app} on {result.backend}", *place, *seed])


def rehearsed_heading(result: RunResult, recorded: RunResult) -> str:
    """Return what was rehearsed on what: ``avoid-obstacles on the samples of green-search on kinematic, arena``."""
    return f"{result.app} on the samples of {heading(recorded)}"


def measures(result: RunResult) -> Iterator[str]:
    """Yield what the run was measured by, in words."""
    if result.outcome is Outcome.SUCCESS and result.verified is not None:
        yield result.dispute or f"verified by the {result.verifier}"
    pace = result.sim_time_s / max(result.wall_time_s, 1e-3)
    yield f"{result.sim_time_s:.1f} s at {pace:.{0 if pace >= 10 else 1}f}x real time"
    if result.distance_to_target_m is not None:
        yield f"{result.distance_to_target_m:.2f} m from the target"
    if result.contacts is not None:
        yield counted(result.contacts, "contact")
    if result.overruns:
        yield counted(result.overruns, "overrun")
    for name, told in result.batteries.items():
        yield f"{name} at {told['last_v']:.2f} V, at its lowest {told['lowest_v']:.2f} V"


def events(result: RunResult) -> Iterator[str]:
    """Yield the milestones, and the faults on purpose, where there were any."""
    if result.milestones:
        yield ", ".join(f"{name} at {time:.1f} s" for name, time in result.milestones.items())
    yield from faults(result)


def faults(result: RunResult) -> Iterator[str]:
    """Yield which faults on purpose there were, and which the run did not live to see."""
    for what, is_seen in (("with faults", True), ("ended before", False)):
        if told := [text for text in result.faults if (Spec.parse(text).after_s <= result.sim_time_s) is is_seen]:
            yield f"{what}: {'; '.join(told)}"
