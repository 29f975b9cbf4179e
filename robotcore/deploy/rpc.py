"""Calls to the agent on a robot, and transfers, over one ssh connection."""

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
from robotcore.deploy.answers import AnswerT, EmptyAnswer, Notice, Refusal, parse, validate
from robotcore.deploy.errors import call_failed, damaged_answer
from robotcore.deploy.host import Host
from robotcore.deploy.process_output import MalformedError, ProcessOutput, split_lines
from robotcore.deploy.rsync import OnPoll, OnProgress, Transfer
from robotcore.deploy.ssh import Connection
from robotcore.errors import DeployError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.text import escape

if TYPE_CHECKING:
    from importlib.abc import Traversable  # moved in 3.11, and gone from here in 3.14


OnNotice = Callable[[Notice], object]
"""Is called with what the robot says of progress."""

OnLine = Callable[[str], object]
"""Is called with each line that an action lets through, escaped and without its end."""

MAX_ANSWER_BYTES = 1 << 24
"""The most bytes that a robot may write in answer to one call."""

SILENCE_S = 900.0
"""A call has failed if nothing comes for this time. Building by pip and reading large recordings take less."""


def ignore(*arguments: object, **more: object) -> None:
    """Do nothing."""


class Link:
    """A robot that is connected to while this is entered.

    ``config`` is a file of ssh's to be used in place of the user's own. Everything raises DeployError, in words that
    say what to do; whatever ends a call or a transfer here ends it on the robot too.
    """

    def __init__(self, host: Host, config: Path | None = None) -> None:
        self.host = host
        self._connection = Connection(host, config)

    def __enter__(self) -> Link:
        self._connection.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._connection.__exit__(kind, error, traceback)

    def call(self, action: str, answer: type[AnswerT], /, on_notice: OnNotice = ignore, **arguments: Any) -> AnswerT:
        """Let the robot do an action with these arguments, and return its validated answer.

        Raises DeployError with the robot's ``kind`` if the robot refuses, and with the kind `DAMAGED` if its answer
        does not fit the model, is too long, or does not come.
        """
        return self._ask(Call(action, answer, on_notice), arguments)

    def stream(self, action: str, /, on_line: OnLine, most: int | None, **arguments: Any) -> None:
        """Do an action, and pass on each line that it lets through, escaped, until one side ends it.

        ``most`` is how many bytes may come; None is for a stream that is followed without an end.
        """
        self._ask(Call(action, EmptyAnswer, on_line=on_line, most=most), arguments)

    def send(self, folder: Path, to: str, copy_from: str | None = None, on_progress: OnProgress = ignore) -> Transfer:
        """Send what is in a folder into a folder that is there, below `Layout.root`.

        A file that is the same in ``copy_from``, a folder below `Layout.root` too, is copied there.
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
        """Bring recordings by name into a folder here; nothing is deleted on the robot.

        What comes in part when the connection breaks is kept in ``partial``, and goes on next time. ``on_poll`` is
        called while it goes on, at least every half second, and ends it by what it raises.
        """
        return rsync.receive(self._connection, self.host, what, folder, partial, on_poll, on_progress)

    def _ask(self, call: Call[AnswerT], arguments: Mapping[str, Any]) -> AnswerT:
        with tempfile.TemporaryFile() as script:
            script.write(build_script(call.action, arguments).encode("ascii"))
            script.seek(0)
            with self._running(script) as process:
                output = ProcessOutput(process)
                try:
                    answer = call.parse_answer(output.pieces())
                except MalformedError as error:
                    raise damaged_answer(self.host, call.action, str(error)) from error
            if answer is None:
                raise self._connection.find_cause(call_failed(self.host, process.returncode, output.stderr_excerpt))
        if isinstance(answer, Refusal):
            raise DeployError(f"{self.host}: {answer.fault}. {answer.remedy}", kind=answer.kind)
        return answer

    @contextmanager
    def _running(self, script: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
        """Run a script there; whatever is raised meanwhile ends it."""
        command = [*self._connection.client, REMOTE_COMMAND]
        with subprocess.Popen(  # noqa: S603  words of ours alone
            command, stdin=script, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
        ) as process:
            try:
                yield process
            except BaseException:
                process.terminate()
                process.wait()
                raise


@dataclass
class Call(Generic[AnswerT]):
    """One call: the model of its answer, and the callbacks for the output before the answer."""

    action: str
    answer: type[AnswerT]
    on_notice: OnNotice = ignore
    on_line: OnLine = ignore
    most: int | None = MAX_ANSWER_BYTES

    def parse_answer(self, pieces: Iterable[bytes]) -> AnswerT | Refusal | None:
        """Return the answer in the output of a robot, or None if there is none; MalformedError if it is damaged.

        What a login shell prints comes before the first line with a mark, and is dropped.
        """
        answer, has_begun = None, False
        for line in split_lines(self._limit_silence(pieces), self.most):
            words, mark, ours = line.partition(MARK.encode())
            if words and has_begun:
                self.on_line(escape(words.decode(errors="replace"), keep="\t"))
            if mark:
                has_begun = True
                answer = self._read(parse(ours)) or answer
        return answer

    def _read(self, message: Mapping[str, Any]) -> AnswerT | Refusal | None:
        """Return the answer in a message, or None if the message is about progress."""
        if "say" in message:
            self.on_notice(validate(Notice, message, "progress"))
        elif "refused" in message:
            return validate(Refusal, message["refused"], "refused")
        elif "done" in message:
            return validate(self.answer, message["done"], "done")
        elif "begun" not in message:
            raise MalformedError("has a message that is neither progress, nor an answer, nor a refusal")
        return None

    def _limit_silence(self, pieces: Iterable[bytes]) -> Iterator[bytes]:
        """Yield pieces; raises MalformedError if none comes for `SILENCE_S`, unless the stream has no end."""
        clock, heard_s = MonotonicClock(), 0.0
        for piece in pieces:
            if piece:
                heard_s = clock.now()
            elif clock.now() - heard_s > SILENCE_S and self.most is not None:
                raise MalformedError(f"has not come: the robot sent nothing for {SILENCE_S:g} s")
            yield piece


REMOTE_COMMAND = "python3 -I -"
"""The command that the robot's shell runs for each call."""

AGENT_PACKAGE = "robotcore.deploy.agent"
EMPTY_PACKAGES = ("robotcore/__init__.py", "robotcore/deploy/__init__.py")
"""The packages around the agent, which are empty on the robot."""


def build_script(action: str, arguments: Mapping[str, Any]) -> str:
    """Return a Python script, in ASCII, that runs an action of the agent with these arguments."""
    first = files(AGENT_PACKAGE).joinpath("bootstrap.py").read_text(encoding="utf-8")
    given = ", ".join(map(ascii, (json.dumps(agent_sources()), action, json.dumps(arguments))))
    return f"{first}\n\nsys.exit(answer_call({given}))\n"


def agent_sources() -> dict[str, str]:
    """Return the source of each module that works on the robot, by its file."""
    return dict.fromkeys(EMPTY_PACKAGES, "") | dict(_sources(files(AGENT_PACKAGE), AGENT_PACKAGE.replace(".", "/")))


def _sources(folder: Traversable, path: str) -> Iterator[tuple[str, str]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _sources(entry, f"{path}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{path}/{entry.name}", entry.read_text(encoding="utf-8")
