"""The tests' double of a CoppeliaSim, in a process of its own that can be killed, suspended and started again."""

from __future__ import annotations

import re
import shlex
import signal
import sys
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from types import TracebackType

ROOT = Path(__file__).parents[2]


@dataclass
class Double:
    """A context manager. A port of 0 is any free one, and the same one when it is started again.

    Without a ``robot`` its scene is the one that the simulator begins with.
    """

    robot: str | None = None
    world: str = "arena"
    seed: int | None = None
    zmq_port: int = 0
    legacy_port: int = 0

    def __enter__(self) -> Double:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.kill()

    @property
    def arguments(self) -> list[str]:
        """What follows ``python`` on the line that starts it."""
        ports = ["--zmq-port", str(self.zmq_port), "--legacy-port", str(self.legacy_port)]
        robot = ["--robot", self.robot, "--world", self.world] if self.robot else []
        seed = ["--seed", str(self.seed)] if self.seed is not None else []
        return ["-m", "tests.doubles.coppeliasim", *ports, *robot, *seed]

    @property
    def command(self) -> str:
        """The line that starts it in a shell."""
        return shlex.join(["python", *self.arguments])

    def start(self) -> None:
        """Return when it serves."""
        self.launch()
        self.await_serving()

    def launch(self) -> None:
        """Begin to start."""
        self._process = Popen([sys.executable, *self.arguments], stdin=DEVNULL, stdout=PIPE, text=True, cwd=ROOT)  # noqa: S603

    def await_serving(self) -> None:
        """Return when what was launched serves."""
        assert self._process.stdout
        line = self._process.stdout.readline()
        self.zmq_port, self.legacy_port = (int(port) for port in re.findall(r"\d+", line))

    def kill(self) -> None:
        """End it as nobody expects it, whatever it is at."""
        self._process.kill()
        self._process.communicate()

    def suspend(self) -> None:
        """Let it hang: its lines stay open, and nothing is answered."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """End the hanging."""
        self._process.send_signal(signal.SIGCONT)
