"""Calls of the agent on a robot, and transfers of files, over one ssh connection."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Generic

from robotcore.deploy import rsync
from robotcore.deploy.agent.rpc import MARK
from robotcore.deploy.errors import explain_damaged_answer, explain_failed_call
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.process_output import MalformedError, ProcessOutput, split_lines
from robotcore.deploy.robot_answers import AnswerT, EmptyAnswer, ProgressMessage, Refusal, parse, validate
from robotcore.deploy.rsync import OnPoll, OnProgress, Transfer
from robotcore.deploy.ssh import SshConnection
from robotcore.errors import DeployError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.text import escape

if TYPE_CHECKING:
    from importlib.abc import Traversable  # moved in 3.11, and gone from here in 3.14


OnMessage = Callable[[ProgressMessage], object]
"""A function that is called with each progress message of an action."""

OnLine = Callable[[str], object]
"""A function that is called with each line that an action prints, escaped and without the line break."""

MAX_ANSWER_BYTES = 1 << 24
"""The greatest length of a robot's output for one call, in bytes."""

SILENCE_S = 900.0
"""The time without output of the robot, in s, after which a call fails.

A build by pip and the hash of a large recording take less time.
"""


def ignore(*arguments: object, **more: object) -> None:
    """Ignore the arguments: the default for functions that are called with progress."""


class RobotLink:
    """A context manager that connects to a robot, calls the agent there, and transfers files.

    Every method raises DeployError with a remedy. If an exception on this machine interrupts a call or a transfer, the
    robot ends it too.

    host: the robot.
    config: an ssh configuration in place of the user's.
    """

    def __init__(self, host: RobotAddress, config: Path | None = None) -> None:
        self.host = host
        self._connection = SshConnection(host, config)

    def __repr__(self) -> str:
        return f"<RobotLink to {self.host}>"

    def __enter__(self) -> RobotLink:
        self._connection.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._connection.__exit__(kind, error, traceback)

    def call(self, action: str, answer: type[AnswerT], /, on_message: OnMessage = ignore, **arguments: Any) -> AnswerT:
        """Run an action on the robot, and return its validated answer.

        action: the action's name, see `robotcore.deploy.agent.rpc.ACTIONS`.
        answer: the model of the answer.
        on_message: this function is called with each progress message.
        arguments: the parameters of the action.
        Raises DeployError. Its kind is the robot's if the robot refuses the action, and `DAMAGED` if the answer does
        not fit the model, is too long, or does not come in time.
        """
        return self._ask(RemoteCall(action, answer, on_message), arguments)

    def stream(self, action: str, /, on_line: OnLine, max_bytes: int | None, **arguments: Any) -> None:
        """Run an action on the robot that prints lines, and pass each line to a function.

        action: the action's name.
        on_line: this function is called with each line, escaped and without the line break.
        max_bytes: the greatest length of the robot's output in bytes; None for a stream without an end.
        arguments: the parameters of the action.
        """
        self._ask(RemoteCall(action, EmptyAnswer, on_line=on_line, max_bytes=max_bytes), arguments)

    def send(self, folder: Path, to: str, copy_from: str | None = None, on_progress: OnProgress = ignore) -> Transfer:
        """Copy the contents of a folder to the robot.

        folder: the folder on this machine.
        to: an existing folder on the robot, relative to `Layout.root`.
        copy_from: another folder on the robot. A file that is equal to one in it is copied there instead of sent.
        on_progress: this function is called with the transferred bytes, and with their fraction of all bytes, 0 to 1.
        """
        return rsync.send(self._connection, self.host, folder, to, copy_from, on_progress)

    def receive(
        self,
        what: Sequence[str],
        folder: Path,
        *,
        partial: Path | None = None,
        on_poll: OnPoll = ignore,
        on_progress: OnProgress = ignore,
    ) -> Transfer:
        """Copy recordings from the robot. They stay on the robot too.

        what: the names of the recordings.
        folder: the folder on this machine.
        partial: the folder that keeps an incomplete file if the connection breaks. The next call completes that file.
        on_poll: this function is called at least every half second. If it raises an exception, the transfer ends.
        on_progress: this function is called with the transferred bytes, and with their fraction of all bytes, 0 to 1.
        """
        return rsync.receive(self._connection, self.host, what, folder, partial, on_poll, on_progress)

    def _ask(self, call: RemoteCall[AnswerT], arguments: Mapping[str, Any]) -> AnswerT:
        with tempfile.TemporaryFile() as script:
            script.write(build_script(call.action, arguments).encode("ascii"))
            script.seek(0)
            with self._run_script(script) as process:
                output = ProcessOutput(process)
                try:
                    answer = call.parse_answer(output.read_pieces())
                except MalformedError as error:
                    raise explain_damaged_answer(self.host, call.action, str(error)) from error
            if answer is None:
                raise self._connection.find_cause(
                    explain_failed_call(self.host, process.returncode, output.stderr_excerpt)
                )
        if isinstance(answer, Refusal):
            raise DeployError(f"{self.host}: {answer.problem}. {answer.remedy}", kind=answer.kind)
        return answer

    @contextmanager
    def _run_script(self, script: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
        command = [*self._connection.ssh_command, REMOTE_COMMAND]
        with subprocess.Popen(  # noqa: S603  constants
            command, stdin=script, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
        ) as process:
            try:
                yield process
            except BaseException:
                process.terminate()
                process.wait()
                raise


@dataclass
class RemoteCall(Generic[AnswerT]):
    """One call of an action. It parses the robot's output."""

    action: str
    answer: type[AnswerT]
    """The model of the answer."""
    on_message: OnMessage = ignore
    on_line: OnLine = ignore
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
            if text and has_begun:
                self.on_line(escape(text.decode(errors="replace"), keep="\t"))
            if mark:
                has_begun = True
                answer = self._parse_message(parse(message)) or answer
        return answer

    def _parse_message(self, message: Mapping[str, Any]) -> AnswerT | Refusal | None:
        if "say" in message:
            self.on_message(validate(ProgressMessage, message, "progress"))
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
    return dict.fromkeys(EMPTY_PACKAGES, "") | dict(
        _read_sources(files(AGENT_PACKAGE), AGENT_PACKAGE.replace(".", "/"))
    )


def _read_sources(folder: Traversable, path: str) -> Iterator[tuple[str, str]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _read_sources(entry, f"{path}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{path}/{entry.name}", entry.read_text(encoding="utf-8")
