"""One ssh connection that all calls and transfers share, so that ssh asks for a password once."""

from __future__ import annotations

import os
import select
import shutil
import subprocess
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType

from robotcore.deploy.errors import (
    SSH_FAILED,
    connection_failed,
    connection_lost,
    damaged_answer,
    login_timed_out,
    program_missing,
)
from robotcore.deploy.host import Host
from robotcore.deploy.process_output import decode_output
from robotcore.errors import DeployError

CONNECT_S, ALIVE_S, ALIVE_COUNT = 10, 5, 3
"""How long to wait for an answer; how often to ask whether the robot is still there, and how often in vain."""

LOGIN_S = 150
"""An sshd hangs up after 120 s without a login, and the login shell takes its time."""

EXIT_GRACE_S = 5

TERMINATE_RETRY_S = 0.2
"""ssh does not see a signal that comes just before it waits for what is typed; so it is given another."""

BREAK_GRACE_S = 1
"""A connection that breaks takes others with it before it is gone itself."""

SOCKET_FOLDER = "/tmp"  # noqa: S108  a folder of nobody else's is made in it
"""Where the socket lies: its path must be short, and macOS's own folder for temporary files is deep."""

GREETING = b"\x1erobotcore\n"
"""Comes back from the robot when its login shell is through with what it prints."""

MASTER_OPTIONS = {
    "ControlMaster": "yes",
    "ControlPersist": "no",
    "ConnectTimeout": CONNECT_S,
    "ServerAliveInterval": ALIVE_S,
    "ServerAliveCountMax": ALIVE_COUNT,
    "ClearAllForwardings": "yes",
    "ForwardAgent": "no",
    "ForwardX11": "no",
    "RemoteCommand": "none",
    "LogLevel": "ERROR",
}
"""What we need, over the user's own configuration; all else is as he has it. A quiet ssh does not say why it fails.
At the level INFO it would print the banner of the robot among its own messages."""

MAX_LOGIN_BYTES = 1 << 20
"""Bytes that a login shell may print."""

LOG_BLOCKS = 1 << 16
"""What a robot writes on stderr goes into the log of ssh: after 32 MB, in blocks of POSIX's ulimit, ssh ends."""

LOG_TAIL_BYTES = 1 << 13
"""Bytes at the end of that log that are read."""

LAUNCHER = ("sh", "-c", f'trap "" INT; ulimit -S -f {LOG_BLOCKS} || :; exec "$@"', "sh")
"""A terminal sends Ctrl-C to the connection too; we still have to say there that nothing more comes."""


class Connection:
    """A connection to a host, entered when the robot has answered; raises DeployError where it does not.

    `client` is the command line, without a robot's command, of whatever goes over it. While it is entered, `cat` runs
    there with our end of its input: should this process be killed, it ends, and ssh with it.
    """

    def __init__(self, host: Host, config: Path | None = None) -> None:
        self._host = host
        self._config = config
        self._unwind = ExitStack()

    @property
    def client(self) -> list[str]:
        """``ssh`` and its options, of which none needs quoting; it looks at no configuration."""
        return ["ssh", "-F", "none", "-S", f"{self._folder}/master", "-o", "ProxyCommand=false", "-T", "robot"]

    def __enter__(self) -> Connection:
        if not shutil.which("ssh"):
            raise program_missing("ssh", "openssh-client")
        with ExitStack() as unwind:
            self._folder = Path(
                unwind.enter_context(tempfile.TemporaryDirectory(prefix="robotcore-ssh-", dir=SOCKET_FOLDER))
            )
            self._master = self._start()
            unwind.callback(self._end)
            self._greet()
            self._unwind = unwind.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._unwind.close()

    def find_cause(self, error: DeployError) -> DeployError:
        """Return the error to raise for a failure: the connection's end if it is gone, else ``error``."""
        if error.kind == DeployError.kind:
            with suppress(subprocess.TimeoutExpired):
                self._master.wait(BREAK_GRACE_S)
                return connection_lost(self._host, self._log())
        return error

    def _start(self) -> subprocess.Popen[bytes]:
        command = (*LAUNCHER, "ssh", *self._options(), "--", self._host.name, "cat")
        with (self._folder / "log").open("ab") as log:  # what ssh says of a broken connection is ours to tell
            return subprocess.Popen(  # noqa: S603  the host is checked, the rest is ours
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log
            )

    def _options(self) -> list[str]:
        """Return the options of ssh: its messages go to a file, its questions to the terminal."""
        host, file = self._host, self._config
        options = MASTER_OPTIONS | ({} if _can_ask() else {"BatchMode": "yes"})
        return [
            *("-S", f"{self._folder}/master", "-E", f"{self._folder}/log", "-T"),
            *(("-F", os.fspath(file)) if file else ()),
            *(("-l", host.user) if host.user else ()),
            *(("-p", str(host.port)) if host.port else ()),
            *(part for name, value in options.items() for part in ("-o", f"{name}={value}")),
        ]

    def _greet(self) -> None:
        """Wait until what is sent there comes back; a question that is open when nobody waits any more is withdrawn."""
        assert self._master.stdin
        assert self._master.stdout
        with suppress(BrokenPipeError):
            self._master.stdin.write(GREETING)
            self._master.stdin.flush()
        try:
            self._await_greeting(self._master.stdout.fileno())
        except BaseException:
            self._cancel()
            raise

    def _cancel(self) -> None:
        """End it while it may be asking: killed outright, it would leave a terminal that shows nothing typed."""
        for _ in range(int(EXIT_GRACE_S / TERMINATE_RETRY_S)):
            self._master.terminate()
            with suppress(subprocess.TimeoutExpired):
                self._master.wait(TERMINATE_RETRY_S)
                return

    def _await_greeting(self, answers: int) -> None:
        received = b""
        while not received.endswith(GREETING):
            if not select.select([answers], [], [], LOGIN_S)[0]:
                raise login_timed_out(self._host, LOGIN_S)
            if not (more := os.read(answers, 4096)):
                status = self._master.wait()
                said = self._log() if status == SSH_FAILED else decode_output(received[-LOG_TAIL_BYTES:])
                raise connection_failed(self._host, status, said, self._config)
            received += more
            if len(received) > MAX_LOGIN_BYTES:
                problem = f"has more than {MAX_LOGIN_BYTES} bytes from the login shell before the greeting"
                raise damaged_answer(self._host, "login", problem)

    def _log(self) -> str:
        with suppress(FileNotFoundError), (self._folder / "log").open("rb") as log:
            log.seek(max(0, os.fstat(log.fileno()).st_size - LOG_TAIL_BYTES))
            return decode_output(log.read(LOG_TAIL_BYTES))
        return ""

    def _end(self) -> None:
        """Say that nothing more comes, and wait for the end; make one where there is none."""
        with self._master as master:
            assert master.stdin
            with suppress(BrokenPipeError):
                master.stdin.close()
            for end in (master.terminate, master.kill):
                with suppress(subprocess.TimeoutExpired):
                    master.wait(EXIT_GRACE_S)
                    return
                end()


def _can_ask() -> bool:
    """Return whether ssh can ask the user, at a terminal or in a window."""
    if os.environ.get("SSH_ASKPASS"):
        return True
    with suppress(OSError):
        os.close(os.open("/dev/tty", os.O_RDWR | os.O_NOCTTY))
        return True
    return False
