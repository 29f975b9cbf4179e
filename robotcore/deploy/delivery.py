"""A release gets onto a robot, beside those that are there: none that runs is touched."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace

from robotcore.deploy.agent.files import format_bytes, measure_size
from robotcore.deploy.agent.releases import WHEELS, Release
from robotcore.deploy.connection.answers import BeginAnswer, Finding, InstallAnswer, Nothing, ProbeAnswer
from robotcore.deploy.connection.link import Link
from robotcore.deploy.packages.target import Target
from robotcore.deploy.packages.wheelhouse import wheels_for
from robotcore.deploy.progress import Step, Tell, begin
from robotcore.deploy.staging.staging import Staged
from robotcore.errors import DeployError
from robotcore.text import counted

BAD = ("error", "warning")
"""The levels of a doctor's findings that are told of in full, the worst first."""


class Delivery:
    """A release on its way to a robot that is connected to: it is to `look`, and then to `make`."""

    def __init__(self, link: Link, release: Release, staged: Staged, tell: Tell) -> None:
        self._link, self._release, self._staged, self._tell = link, release, staged, tell
        self._has_environment, self._target = False, Target("", "")

    def look(self, step: Step) -> None:
        """Tell what the robot is; raise DeployError where it cannot take a release of the project."""
        facts = self._link.call("probe", ProbeAnswer, requirements=self._release.requirements, is_push=True)
        room = f"{format_bytes(facts.free_bytes)} free"
        step.done(f"{facts.host}: {facts.machine}, {facts.system}, Python {facts.python}, {room}")
        self._target, self._has_environment = Target.of(facts), facts.has_environment
        self._target.require_python(self._staged.project)

    def make(self, *, is_offline: bool) -> str:
        """Send it, install what it needs, and let its doctor look; return the name that the robot has given it.

        Where that fails, the robot forgets it.
        """
        if is_offline and not self._has_environment:
            self._add_wheels()
        step = begin("sent", self._tell)
        begun = self._link.call(
            "begin", BeginAnswer, release=self._release.name, size=measure_size(self._staged.folder)
        )
        release = replace(self._release, name=begun.release)
        with self._forgetting(release.name):
            release.write(self._staged.folder)
            self._send(begun, step)
            self._install(release.name, is_offline=is_offline)
        return release.name

    @contextmanager
    def _forgetting(self, release: str) -> Iterator[None]:
        """While entered, whatever is raised lets the robot throw away what it got; where it cannot, it does later."""
        try:
            yield
        except BaseException:
            with suppress(DeployError):
                self._link.call("discard", Nothing, release=release)
            raise

    def _add_wheels(self) -> None:
        """Put them beside what is sent: they go with it, and no other push has to do with them."""
        step = begin("wheels", self._tell)
        wheels = wheels_for(self._release.requirements, self._target, step.say)
        shutil.copytree(wheels, self._staged.folder / WHEELS)
        step.done(f"{len(list(wheels.iterdir()))} for {self._target}")

    def _send(self, begun: BeginAnswer, step: Step) -> None:
        went = self._link.send(self._staged.folder, begun.to, begun.copy_from, _saying(step))
        step.done(f"{went.files} files, {went.changed} of them new, {format_bytes(went.sent)}", *self._staged.notes)

    def _install(self, release: str, *, is_offline: bool) -> None:
        step = begin("environment", self._tell)
        made = self._link.call(
            "install", InstallAnswer, on_say=lambda notice: step.say(notice.say), release=release, is_offline=is_offline
        )
        step.done(made.environment)
        _tell_findings(made.findings, begin("doctor", self._tell))


def _saying(step: Step) -> Callable[[int, float], None]:
    return lambda size, part: step.say(f"{part:.0%}, {format_bytes(size)}")


def _tell_findings(findings: Sequence[Finding], step: Step) -> None:
    """Tell what the doctor found. An error raises nothing: the trial shows whether the app lives with it."""
    counts = Counter(finding.level for finding in findings)
    bad = [finding for level in BAD for finding in findings if finding.level == level]
    said = [f"{counts['ok']} ok", *(counted(counts[level], level) for level in BAD if counts[level])]
    step.done(", ".join(said), *(_in_a_line(finding) for finding in bad))


def _in_a_line(finding: Finding) -> str:
    remedy = f". {finding.remedy}" if finding.remedy else ""
    return f"{finding.level}: {finding.what}: {finding.said}{remedy}"
