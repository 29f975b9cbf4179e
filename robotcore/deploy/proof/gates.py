"""What a project must pass before anything of it is sent: its tests, its descriptions, its app in simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from robotcore.deploy.progress import Tell, begin
from robotcore.deploy.project import Project
from robotcore.deploy.proof import check, simulation, tests
from robotcore.deploy.proof.proof import Proof, Say
from robotcore.deploy.staging.staging import Staged

SubjectT = TypeVar("SubjectT")


@dataclass(frozen=True)
class Gate(Generic[SubjectT]):
    """One of the things to pass. ``prove`` returns the proof, or raises UnprovenError: why, and what repeats it.

    It also raises what is wrong with the project's files, or with this machine, as it is. ``say`` is told what goes on.
    """

    name: str
    prove: Callable[[SubjectT, Say], Proof]


AT_DESK = (Gate[Project]("tests", tests.prove), Gate[Project]("check", check.prove))
"""Looks at the user's own folder."""

AS_SENT = (Gate[Staged]("simulation", simulation.prove),)
"""Looks at what is to be sent; that is gathered in between."""

NAMES = tuple(gate.name for gate in (*AT_DESK, *AS_SENT))


def passed(gates: Sequence[Gate[SubjectT]], subject: SubjectT, tell: Tell) -> tuple[str, ...]:
    """Pass gates; return a line for each, as a release keeps them: ``tests: 12 passed``."""
    lines = []
    for gate in gates:
        step = begin(gate.name, tell)
        proof = gate.prove(subject, step.say)
        step.done(proof.said, *proof.notes)
        lines.append(f"{gate.name}: {proof.said}")
    return tuple(lines)


def skipped(tell: Tell) -> tuple[str, ...]:
    """Say that none is passed; return a line for each, as a release keeps them."""
    begin("skipped", tell).done(", ".join(NAMES))
    return tuple(f"{name}: skipped" for name in NAMES)
