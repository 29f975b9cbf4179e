"""The interface of a backend's loopback test: a person connects pins by wires, and the backend measures over them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from robotcore.description import RobotDescription


class Verdict(str, Enum):
    """Whether a rule holds."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class RuleResult:
    """The result of one rule of a loopback test.

    >>> result = RuleResult.from_measurement("stop-command", "1.2 ms", "at most 50 ms", is_met=True, worst_ms=1.2)
    >>> result.verdict.value, result.values
    ('passed', {'worst_ms': 1.2})
    """

    rule: str
    """A stable identifier in kebab-case, such as ``stop-sigkill``."""
    verdict: Verdict
    """The result of the rule."""
    measured: str = ""
    """The measured value with its unit, as text; empty for a skipped rule."""
    bound: str = ""
    """The bound, as text."""
    reason: str = ""
    """Why the rule was skipped, or what the user can do about a failure."""
    values: Mapping[str, float] = field(default_factory=dict)
    """The measured numbers by their names, which end in the unit."""

    @classmethod
    def from_measurement(
        cls, rule: str, measured: str, bound: str, *, is_met: bool, reason: str = "", **values: float
    ) -> RuleResult:
        """Return the result of a rule that was measured. A rule that is met has no reason."""
        verdict = Verdict.PASSED if is_met else Verdict.FAILED
        return cls(rule, verdict, measured, bound, "" if is_met else reason, values)

    @classmethod
    def fail(cls, rule: str, reason: str) -> RuleResult:
        """Return the result of a rule whose measurement failed, so that it has no value."""
        return cls(rule, Verdict.FAILED, reason=reason)

    @classmethod
    def skip(cls, rule: str, reason: str) -> RuleResult:
        """Return the result of a rule that was left out, or that the test has not reached."""
        return cls(rule, Verdict.SKIPPED, reason=reason)


@dataclass(frozen=True)
class LoopbackRequest:
    """The options of a loopback test, as the user gives them."""

    robot: RobotDescription | None = None
    """The robot with the motor to test; None to test no motor."""
    robot_reference: str = ""
    """The name or file of that robot."""
    wires: tuple[tuple[int, int], ...] = ()
    """The pins of each wire: the output and the input. Empty: the test chooses free pins."""
    motor: str | None = None
    """The name of the motor to test; None for the first one."""
    is_real_time: bool = False
    """Whether the ticks are also measured with real-time priority."""
    tick_test_s: float = 10.0
    """The duration of each measurement of the ticks, in seconds."""


class LoopbackPerson(Protocol):
    """The person who connects the wires and looks at the motor."""

    def confirm(self, topic: str, instruction: str) -> bool:
        """Return whether the person has followed an instruction. False skips the step."""

    def choose(self, topic: str, question: str, choices: Mapping[str, str]) -> str | None:
        """Return the key of the person's choice; None if the person skips the question."""


class LoopbackTest(ABC):
    """A loopback test of one board. `run` may be called once."""

    @property
    @abstractmethod
    def rules(self) -> tuple[str, ...]:
        """The identifiers of all rules, in the order of their results."""

    @property
    @abstractmethod
    def topics(self) -> Mapping[str, tuple[str, ...]]:
        """The answers that each question accepts, by the question's topic."""

    @property
    @abstractmethod
    def pins(self) -> tuple[tuple[int, int], ...]:
        """The output and the input of each wire."""

    @abstractmethod
    def describe_board(self) -> Mapping[str, str]:
        """Return facts about the board by name, such as its model and its libraries. None of them is private."""

    @abstractmethod
    def run(self, person: LoopbackPerson, write: Callable[[str], object]) -> Generator[RuleResult, None, None]:
        """Yield the result of each rule. At the end, and after an exception, every pin is low and released.

        write: a function that shows a line of text, such as the step that begins.
        """
