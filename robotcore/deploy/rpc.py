"""Calls of the agent on a robot over an ssh connection."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib.resources import files
from typing import Any

from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.errors import CALL_FAILED, explain_damaged_answer, find_last_line
from robotcore.deploy.process_output import MalformedError, run_process, split_lines
from robotcore.deploy.progress import OnText
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

REMOTE_COMMAND = "python3 -I -"
"""The command that the robot's shell runs for each call."""

_AGENT_COMMAND = re.compile(r"robotcore deploy ([a-z]+(?: --[a-z]+)*)")
"""The pattern of a command in an agent's remedy. The agent does not know the robot's address."""

COMMAND_NOT_FOUND = 127
"""The exit status of a shell that did not find a command."""


class RobotLink(SshConnection):
    """A connection to a robot that calls the agent there.

    Every method raises DeployError with a remedy. Its kind is the robot's if the robot refuses the action, and
    `DAMAGED` if the answer does not fit the model, is too long, or does not come in time.
    """

    def call(
        self, action: str, answer: type[AnswerT], /, on_message: OnMessage | None = None, **arguments: Any
    ) -> AnswerT:
        """Run an action on the robot, and return its validated answer.

        action: the action's name, see `robotcore.deploy.agent.rpc.ACTIONS`.
        answer: the model of the answer.
        on_message: this function is called with each progress message.
        arguments: the parameters of the action.
        """
        return self._ask(action, arguments, answer, on_message=on_message)

    def stream(self, action: str, /, on_line: OnText, max_bytes: int | None, **arguments: Any) -> None:
        """Run an action on the robot that prints lines, and pass each line to a function.

        on_line: this function is called with each line, escaped and without the line break.
        max_bytes: the greatest length of the robot's output in bytes; None for a stream without an end.
        """
        self._ask(action, arguments, EmptyAnswer, on_line=on_line, max_bytes=max_bytes)

    def _ask(self, action: str, arguments: Mapping[str, Any], model: type[AnswerT], **reading: Any) -> AnswerT:
        script = build_script(action, arguments).encode("ascii")
        try:
            with run_process([*self.ssh_command, REMOTE_COMMAND], script) as output:
                answer = parse_answer(output.read_pieces(), model, **reading)
        except MalformedError as error:
            raise explain_damaged_answer(self.host, action, str(error)) from error
        if answer is None:
            raise self.find_cause(self._explain_no_answer(output.status, output.stderr_excerpt))
        if isinstance(answer, Refusal):
            remedy = _AGENT_COMMAND.sub(lambda found: self.host.format_command(found[1]), answer.remedy)
            raise DeployError(f"{self.host}: {answer.problem}. {remedy}", kind=answer.kind)
        return answer

    def _explain_no_answer(self, status: int, output: str) -> DeployError:
        if status == COMMAND_NOT_FOUND:
            problem = "python3 is missing on the robot. On the robot: sudo apt install python3"
            return DeployError(f"{self.host}: {problem}", kind="python")
        return DeployError(
            f"{self.host}: the call failed on the robot (status {status}): {find_last_line(output)}. Log in to find "
            f"the cause: ssh {self.host.login}",
            kind=CALL_FAILED,
            status=status,
        )


def parse_answer(
    pieces: Iterable[bytes],
    model: type[AnswerT],
    *,
    on_message: OnMessage | None = None,
    on_line: OnText | None = None,
    max_bytes: int | None = MAX_ANSWER_BYTES,
) -> AnswerT | Refusal | None:
    """Return the answer in a robot's output, or None if the output has no answer.

    The function ignores the lines before the first `MARK`, because a login shell prints them.

    max_bytes: the greatest length of the output in bytes; None for a stream without an end.
    Raises MalformedError if the output is malformed.
    """
    answer: AnswerT | Refusal | None = None
    has_begun = False
    for line in split_lines(pieces if max_bytes is None else _limit_silence(pieces), max_bytes):
        text, mark, content = line.partition(MARK.encode())
        if text and has_begun and on_line:
            on_line(escape(text.decode(errors="replace"), keep="\t"))
        if not mark:
            continue
        has_begun, message = True, parse(content)
        if "text" in message:
            progress = validate(ProgressMessage, message, "progress")
            if on_message:
                on_message(progress)
        elif "refused" in message:
            answer = validate(Refusal, message["refused"], "refused")
        elif "done" in message:
            answer = validate(model, message["done"], "done")
        elif "begun" not in message:
            raise MalformedError("has a message that is neither progress, nor an answer, nor a refusal")
    return answer


def _limit_silence(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Yield the pieces. Raise MalformedError if no piece comes for `SILENCE_S`."""
    clock, received_s = MonotonicClock(), 0.0
    for piece in pieces:
        if piece:
            received_s = clock.now()
        elif clock.now() - received_s > SILENCE_S:
            raise MalformedError(f"has not come: the robot sent nothing for {SILENCE_S:g} s")
        yield piece


AGENT_PACKAGE = "robotcore.deploy.agent"
"""The package that runs on the robot."""


def build_script(action: str, arguments: Mapping[str, Any]) -> str:
    """Return a Python script in ASCII that contains the agent's source and runs one of its actions.

    The arguments are string literals with JSON, so that Python never runs them as code.

    arguments: the parameters of the action, which JSON can represent.
    """
    first = files(AGENT_PACKAGE).joinpath("bootstrap.py").read_text(encoding="utf-8")
    literals = ", ".join(map(ascii, (json.dumps(read_agent_sources()), action, json.dumps(arguments))))
    return f"{first}\n\nsys.exit(answer_call({literals}))\n"


def read_agent_sources() -> dict[str, str]:
    """Return the source text of each module of the agent by its path, such as ``robotcore/deploy/agent/files.py``.

    The agent's parent packages are empty on the robot.
    """
    path = AGENT_PACKAGE.replace(".", "/")
    modules = [entry for entry in files(AGENT_PACKAGE).iterdir() if entry.name.endswith(".py")]
    sources = {f"{path}/{entry.name}": entry.read_text(encoding="utf-8") for entry in modules}
    return dict.fromkeys(("robotcore/__init__.py", "robotcore/deploy/__init__.py"), "") | sources
