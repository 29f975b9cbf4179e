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
class DoubleProcess:
    """A double of CoppeliaSim in its own process, as a context manager.

    A port of 0 means any free port, which stays the same after a restart. Without ``robot``, the scene is the default
    scene of the simulator.
    """

    robot: str | None = None
    world: str = "arena"
    seed: int | None = None
    zmq_port: int = 0
    legacy_port: int = 0

    def __enter__(self) -> DoubleProcess:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.kill()

    @property
    def arguments(self) -> list[str]:
        """The arguments of ``python`` that start the double."""
        ports = ["--zmq-port", str(self.zmq_port), "--legacy-port", str(self.legacy_port)]
        robot = ["--robot", self.robot, "--world", self.world] if self.robot else []
        seed = ["--seed", str(self.seed)] if self.seed is not None else []
        return ["-m", "tests.doubles.coppeliasim", *ports, *robot, *seed]

    @property
    def command(self) -> str:
        """The shell command that starts the double."""
        return shlex.join(["python", *self.arguments])

    def start(self) -> None:
        """Start the process, and wait until the double serves."""
        self.launch()
        self.await_serving()

    def launch(self) -> None:
        """Start the process, and return at once."""
        self._process = Popen([sys.executable, *self.arguments], stdin=DEVNULL, stdout=PIPE, text=True, cwd=ROOT)  # noqa: S603

    def await_serving(self) -> None:
        """Wait until the started process serves."""
        assert self._process.stdout
        line = self._process.stdout.readline()
        self.zmq_port, self.legacy_port = (int(port) for port in re.findall(r"\d+", line))

    def kill(self) -> None:
        """Kill the process."""
        self._process.kill()
        self._process.communicate()

    def suspend(self) -> None:
        """Suspend the process. Its connections stay open, and it does not answer."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Resume the suspended process."""
        self._process.send_signal(signal.SIGCONT)
