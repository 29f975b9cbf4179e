"""Calls of the agent on a robot, and transfers of files, over one ssh connection."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Generic

from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.errors import explain_damaged_answer, explain_failed_call
from robotcore.deploy.process_output import MalformedError, ProcessOutput, split_lines
from robotcore.deploy.progress import Report
from robotcore.deploy.robot_answers import AnswerT, EmptyAnswer, ProgressMessage, Refusal, parse, validate
from robotcore.deploy.ssh import SshConnection
from robotcore.errors import DeployError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.text import escape

OnMessage = Callable[[ProgressMessage], object]
"""A function that is called with each progress message of an action."""

MAX_ANSWER_BYTES = 1 << 24
"""The greatest length of a robot's output for one call, in bytes."""

SILENCE_S = 900.0
"""The time without output of the robot, in s, after which a call fails.

A build by pip and the hash of a large recording take less time.
"""


class RobotLink(SshConnection):
    """A connection to a robot that calls the agent there.

    Every method raises DeployError with a remedy.
    """

    def call(
        self, action: str, answer: type[AnswerT], /, on_message: OnMessage | None = None, **arguments: Any
    ) -> AnswerT:
        """Run an action on the robot, and return its validated answer.

        action: the action's name, see `robotcore.deploy.agent.rpc.ACTIONS`.
        answer: the model of the answer.
        on_message: this function is called with each progress message.
        arguments: the parameters of the action.
        Raises DeployError. Its kind is the robot's if the robot refuses the action, and `DAMAGED` if the answer does
        not fit the model, is too long, or does not come in time.
        """
        return self._ask(RemoteCall(action, answer, on_message), arguments)

    def stream(self, action: str, /, on_line: Report, max_bytes: int | None, **arguments: Any) -> None:
        """Run an action on the robot that prints lines, and pass each line to a function.

        action: the action's name.
        on_line: this function is called with each line, escaped and without the line break.
        max_bytes: the greatest length of the robot's output in bytes; None for a stream without an end.
        arguments: the parameters of the action.
        """
        self._ask(RemoteCall(action, EmptyAnswer, on_line=on_line, max_bytes=max_bytes), arguments)

    def _ask(self, call: RemoteCall[AnswerT], arguments: Mapping[str, Any]) -> AnswerT:
        with tempfile.TemporaryFile() as script:
            script.write(build_script(call.action, arguments).encode("ascii"))
            script.seek(0)
            with subprocess.Popen(  # noqa: S603  constants
                [*self.ssh_command, REMOTE_COMMAND],
                stdin=script,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            ) as process:
                output = ProcessOutput(process)
                try:
                    answer = call.parse_answer(output.read_pieces())
                except BaseException as error:
                    process.terminate()
                    process.wait()
                    if isinstance(error, MalformedError):
                        raise explain_damaged_answer(self.host, call.action, str(error)) from error
                    raise
            if answer is None:
                raise self.find_cause(explain_failed_call(self.host, process.returncode, output.stderr_excerpt))
        if isinstance(answer, Refusal):
            raise DeployError(f"{self.host}: {answer.problem}. {answer.remedy}", kind=answer.kind)
        return answer


@dataclass
class RemoteCall(Generic[AnswerT]):
    """One call of an action. It parses the robot's output."""

    action: str
    answer: type[AnswerT]
    """The model of the answer."""
    on_message: OnMessage | None = None
    on_line: Report | None = None
    max_bytes: int | None = MAX_ANSWER_BYTES
    """The greatest length of the output in bytes; None for a stream without an end."""

    def parse_answer(self, pieces: Iterable[bytes]) -> AnswerT | Refusal | None:
        """Return the answer in a robot's output, or None if the output has no answer.

        The method ignores the lines before the first `MARK`, because a login shell prints them.

        Raises MalformedError if the output is malformed.
        """
        answer, has_begun = None, False
        for line in split_lines(self._limit_silence(pieces), self.max_bytes):
            text, mark, message = line.partition(MARK.encode())
            if text and has_begun and self.on_line:
                self.on_line(escape(text.decode(errors="replace"), keep="\t"))
            if mark:
                has_begun = True
                answer = self._parse_message(parse(message)) or answer
        return answer

    def _parse_message(self, message: Mapping[str, Any]) -> AnswerT | Refusal | None:
        if "say" in message:
            progress = validate(ProgressMessage, message, "progress")
            if self.on_message:
                self.on_message(progress)
        elif "refused" in message:
            return validate(Refusal, message["refused"], "refused")
        elif "done" in message:
            return validate(self.answer, message["done"], "done")
        elif "begun" not in message:
            raise MalformedError("has a message that is neither progress, nor an answer, nor a refusal")
        return None

    def _limit_silence(self, pieces: Iterable[bytes]) -> Iterator[bytes]:
        """Yield the pieces. Raise MalformedError if no piece comes for `SILENCE_S`, except in an endless stream."""
        clock, received_s = MonotonicClock(), 0.0
        for piece in pieces:
            if piece:
                received_s = clock.now()
            elif clock.now() - received_s > SILENCE_S and self.max_bytes is not None:
                raise MalformedError(f"has not come: the robot sent nothing for {SILENCE_S:g} s")
            yield piece


REMOTE_COMMAND = "python3 -I -"
"""The command that the robot's shell runs for each call."""

AGENT_PACKAGE = "robotcore.deploy.agent"
"""The package that runs on the robot."""

EMPTY_PACKAGES = ("robotcore/__init__.py", "robotcore/deploy/__init__.py")
"""The files of the agent's parent packages. They are empty on the robot."""


def build_script(action: str, arguments: Mapping[str, Any]) -> str:
    """Return a Python script in ASCII that contains the agent's source and runs one of its actions.

    The arguments are string literals with JSON, so that Python never runs them as code.

    action: the action's name.
    arguments: the parameters of the action, which JSON can represent.
    """
    first = files(AGENT_PACKAGE).joinpath("bootstrap.py").read_text(encoding="utf-8")
    literals = ", ".join(map(ascii, (json.dumps(read_agent_sources()), action, json.dumps(arguments))))
    return f"{first}\n\nsys.exit(answer_call({literals}))\n"


def read_agent_sources() -> dict[str, str]:
    """Return the source text of each module of the agent by its path, such as ``robotcore/deploy/agent/files.py``."""
    path = AGENT_PACKAGE.replace(".", "/")
    modules = [entry for entry in files(AGENT_PACKAGE).iterdir() if entry.name.endswith(".py")]
    sources = {f"{path}/{entry.name}": entry.read_text(encoding="utf-8") for entry in modules}
    return dict.fromkeys(EMPTY_PACKAGES, "") | sources
