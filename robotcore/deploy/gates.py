"""What a project must pass before anything of it is sent: its tests, its descriptions, its app in simulation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from robotcore.deploy.project import Project
from robotcore.deploy.proof import check, simulation, tests
from robotcore.deploy.proof.proof import Proof, Say


@dataclass(frozen=True)
class Gate:
    """One of the things to pass. ``prove`` returns the proof, or raises UnprovenError: why, and what repeats it.

    It also raises what is wrong with the project's files, or with this machine, as it is. ``say`` is told what goes on.
    """

    name: str
    prove: Callable[[Project, Say], Proof]


GATES = (Gate("tests", tests.prove), Gate("check", check.prove), Gate("simulation", simulation.prove))
"""In this order, the quickest first."""


def skipped() -> dict[str, Proof]:
    """Return what is told of the gates where nothing is proven."""
    return {gate.name: Proof("skipped") for gate in GATES}


def lines_of(proofs: Mapping[str, Proof]) -> tuple[str, ...]:
    """Return a line for each gate, as a release keeps them: ``tests: 12 passed``."""
    return tuple(f"{gate}: {proof.said}" for gate, proof in proofs.items())
