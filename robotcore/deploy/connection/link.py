"""What is asked of a robot, and what goes there and comes back: everything over one ssh connection."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from robotcore.deploy.aboard.telling import MARK
from robotcore.deploy.connection import boot, rsync
from robotcore.deploy.connection.failures import unanswered
from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.rsync import OnProgress, Transfer
from robotcore.deploy.connection.ssh import Connection
from robotcore.errors import DeployError

OnSay = Callable[..., object]
"""Hears of progress as the robot's `say` tells it: words, and more by name."""

OnLine = Callable[[str], object]
"""Hears a line that is only passed through, without its end."""


def unheard(*told: object, **more: object) -> None:
    """Hear nothing."""


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

    def call(self, action: str, /, on_say: OnSay = unheard, **told: Any) -> Mapping[str, Any]:
        """Let the robot do an action with what it is told by name, and return what it has to tell.

        Raises DeployError with the robot's ``kind`` where it refuses.
        """
        return self._ask(action, told, on_say, unheard)

    def stream(self, action: str, /, on_line: OnLine, **told: Any) -> Mapping[str, Any]:
        """Do as `call` does, and pass on each line that the action lets through, until one side ends it."""
        return self._ask(action, told, unheard, on_line)

    def send(self, folder: Path, to: str, copy_from: str | None = None, on_progress: OnProgress = unheard) -> Transfer:
        """Send what is in a folder into a folder that is there, below `Layout.root`.

        A file that is the same in ``copy_from``, a folder below `Layout.root` too, is copied there.
        """
        return rsync.send(self._connection, self.host, folder, to, copy_from, on_progress)

    def bring(
        self,
        what: Sequence[str],
        folder: Path,
        *,
        moves: bool = False,
        on_progress: OnProgress = unheard,
    ) -> Transfer:
        """Bring recordings by name into a folder here; ``moves`` takes each away there once it is whole here.

        What was brought in part when the connection broke is kept apart, and goes on next time.
        """
        return rsync.bring(self._connection, self.host, what, folder, on_progress, moves=moves)

    def _ask(self, action: str, told: Mapping[str, Any], on_say: OnSay, on_line: OnLine) -> Mapping[str, Any]:
        with tempfile.TemporaryFile() as script, tempfile.TemporaryFile() as errors:
            script.write(boot.script(action, told).encode("ascii"))
            script.seek(0)
            with self._running(script, errors) as process:
                assert process.stdout
                answer = _heard(process.stdout, on_say, on_line)
            if answer is None:
                errors.seek(0)
                said = errors.read().decode(errors="replace")
                raise self._connection.blame(unanswered(self.host, process.returncode, said))
        if "refused" in answer:
            refused = answer["refused"]
            raise DeployError(f"{self.host}: {refused['fault']}. {refused['remedy']}", refused["kind"])
        done: Mapping[str, Any] = answer["done"]
        return done

    @contextmanager
    def _running(self, script: IO[bytes], errors: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
        """Run a script there; whatever is raised meanwhile ends it."""
        command = [*self._connection.client, boot.COMMAND]
        with subprocess.Popen(  # noqa: S603  words of ours alone
            command, stdin=script, stdout=subprocess.PIPE, stderr=errors, start_new_session=True
        ) as process:
            try:
                yield process
            except BaseException:
                process.terminate()
                process.wait()
                raise


def _heard(lines: Iterable[bytes], on_say: OnSay, on_line: OnLine) -> Mapping[str, Any] | None:
    """Pass on what the robot says, and return its answer; what a login shell prints comes before, and is dropped."""
    answer, has_begun = None, False
    for line in lines:
        words, mark, ours = line.decode(errors="replace").rstrip("\n").partition(MARK)
        if words and has_begun:
            on_line(words)
        if mark:
            told = json.loads(ours)
            has_begun = True
            if "say" in told:
                on_say(told.pop("say"), **told)
            elif "begun" not in told:
                answer = told
    return answer
