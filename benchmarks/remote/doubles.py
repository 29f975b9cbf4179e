"""The tests' double of CoppeliaSim in its own process, which can be killed, suspended and restarted."""

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
    """A double in its own process; a context manager. A port of 0 is any free port, and stays after a restart.

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
        """The arguments of ``python`` that start it."""
        ports = ["--zmq-port", str(self.zmq_port), "--legacy-port", str(self.legacy_port)]
        robot = ["--robot", self.robot, "--world", self.world] if self.robot else []
        seed = ["--seed", str(self.seed)] if self.seed is not None else []
        return ["-m", "tests.doubles.coppeliasim", *ports, *robot, *seed]

    @property
    def command(self) -> str:
        """The shell command that starts it."""
        return shlex.join(["python", *self.arguments])

    def start(self) -> None:
        """Start it, and return when it serves."""
        self.launch()
        self.await_serving()

    def launch(self) -> None:
        """Start it, and return at once."""
        self._process = Popen([sys.executable, *self.arguments], stdin=DEVNULL, stdout=PIPE, text=True, cwd=ROOT)  # noqa: S603

    def await_serving(self) -> None:
        """Return when the launched process serves."""
        assert self._process.stdout
        line = self._process.stdout.readline()
        self.zmq_port, self.legacy_port = (int(port) for port in re.findall(r"\d+", line))

    def kill(self) -> None:
        """Kill it."""
        self._process.kill()
        self._process.communicate()

    def suspend(self) -> None:
        """Suspend it. Its connections stay open, and it answers nothing."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Resume it."""
        self._process.send_signal(signal.SIGCONT)
