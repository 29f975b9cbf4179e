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
    CALL_FAILED,
    RSYNC_FAILED,
    SSH_FAILED,
    explain_damaged_answer,
    explain_failed_connection,
    explain_login_timeout,
    explain_lost_connection,
    explain_missing_program,
)
from robotcore.deploy.host import Host
from robotcore.deploy.process_output import decode_output
from robotcore.errors import DeployError

CONNECT_S, ALIVE_S, ALIVE_COUNT = 10, 5, 3
"""The time limit to connect, the time between two keep-alive messages, both in s, and how many may stay unanswered."""

LOGIN_S = 150
"""The time limit of the login, in s: sshd closes a connection after 120 s, and a login shell takes some time."""

EXIT_GRACE_S = 5
"""How long ssh may take to end after its stdin was closed, in s."""

TERMINATE_RETRY_S = 0.2
"""The time between two signals to ssh, in s.

The signal is repeated because ssh misses one that comes just before it waits for a password.
"""

BREAK_GRACE_S = 1
"""How long to wait for the end of ssh after a call has failed, in s.

If the connection breaks, a call may fail shortly before ssh ends.
"""

SOCKET_FOLDER = "/tmp"  # noqa: S108  the socket is in a private folder in it
"""The folder for the socket's private folder.

The path of a socket must be short. The default folder for temporary files on macOS has a long path.
"""

GREETING = b"\x1erobotcore\n"
"""Text that the robot sends back after its login shell has printed everything."""

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
"""The options that override the user's ssh configuration. The rest of that configuration applies.

At a lower log level ssh does not print why it fails. At the level INFO it prints the robot's banner too.
"""

MAX_LOGIN_BYTES = 1 << 20
"""The most bytes that a login shell may print."""

LOG_BLOCKS = 1 << 16
"""The limit of ssh's log, in blocks of POSIX's ulimit: 32 MB, then ssh ends. A robot's stderr goes into this log."""

LOG_TAIL_BYTES = 1 << 13
"""Of the log, only this many bytes at the end are read."""

LAUNCHER = ("sh", "-c", f'trap "" INT; ulimit -S -f {LOG_BLOCKS} || :; exec "$@"', "sh")
"""The command that starts ssh so that it ignores SIGINT. After Ctrl-C, `Connection` itself closes ssh."""


class Connection:
    """A context manager that holds a connection to a host. Raises DeployError if the robot does not answer.

    ``cat`` runs on the robot while the connection is open, with this process at the other end of its stdin. If this
    process is killed, ``cat`` ends, and ssh with it.

    host: the robot.
    config: an ssh configuration in place of the user's.
    """

    def __init__(self, host: Host, config: Path | None = None) -> None:
        self._host = host
        self._config = config
        self._unwind = ExitStack()

    @property
    def ssh_command(self) -> list[str]:
        """The ssh command line that uses the connection, without the remote command. No part of it needs quotes.

        This ssh reads no configuration file.
        """
        return ["ssh", "-F", "none", "-S", f"{self._folder}/master", "-o", "ProxyCommand=false", "-T", "robot"]

    def __enter__(self) -> Connection:
        if not shutil.which("ssh"):
            raise explain_missing_program("ssh", "openssh-client")
        with ExitStack() as unwind:
            self._folder = Path(
                unwind.enter_context(tempfile.TemporaryDirectory(prefix="robotcore-ssh-", dir=SOCKET_FOLDER))
            )
            self._master = self._start()
            unwind.callback(self._close)
            self._send_greeting()
            self._unwind = unwind.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._unwind.close()

    def find_cause(self, error: DeployError) -> DeployError:
        """Return the error to raise after a call has failed with ``error``.

        If the connection has ended, that is the cause, and the returned error says so. Otherwise it is ``error``.
        """
        if error.kind in {CALL_FAILED, RSYNC_FAILED}:
            with suppress(subprocess.TimeoutExpired):
                self._master.wait(BREAK_GRACE_S)
                return explain_lost_connection(self._host, self._read_log())
        return error

    def _start(self) -> subprocess.Popen[bytes]:
        command = (*LAUNCHER, "ssh", *self._build_options(), "--", self._host.name, "cat")
        with (self._folder / "log").open("ab") as log:  # an error message quotes it
            return subprocess.Popen(  # noqa: S603  the host is validated, the rest is constant
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log
            )

    def _build_options(self) -> list[str]:
        """Return the options with which ssh writes messages into a file, and asks questions on the terminal."""
        host, file = self._host, self._config
        options = MASTER_OPTIONS | ({} if _can_ask() else {"BatchMode": "yes"})
        return [
            *("-S", f"{self._folder}/master", "-E", f"{self._folder}/log", "-T"),
            *(("-F", os.fspath(file)) if file else ()),
            *(("-l", host.user) if host.user else ()),
            *(("-p", str(host.port)) if host.port else ()),
            *(part for name, value in options.items() for part in ("-o", f"{name}={value}")),
        ]

    def _send_greeting(self) -> None:
        """Send the greeting, and wait until the robot sends it back. If that fails, end ssh, also during a question."""
        assert self._master.stdin
        assert self._master.stdout
        with suppress(BrokenPipeError):
            self._master.stdin.write(GREETING)
            self._master.stdin.flush()
        try:
            self._await_greeting(self._master.stdout.fileno())
        except BaseException:
            self._cancel_login()
            raise

    def _cancel_login(self) -> None:
        """Terminate ssh by SIGTERM. After SIGKILL during a password question, the terminal would not echo any more."""
        for _ in range(int(EXIT_GRACE_S / TERMINATE_RETRY_S)):
            self._master.terminate()
            with suppress(subprocess.TimeoutExpired):
                self._master.wait(TERMINATE_RETRY_S)
                return

    def _await_greeting(self, answers: int) -> None:
        received = b""
        while not received.endswith(GREETING):
            if not select.select([answers], [], [], LOGIN_S)[0]:
                raise explain_login_timeout(self._host, LOGIN_S)
            if not (more := os.read(answers, 4096)):
                status = self._master.wait()
                said = self._read_log() if status == SSH_FAILED else decode_output(received[-LOG_TAIL_BYTES:])
                raise explain_failed_connection(self._host, status, said, self._config)
            received += more
            if len(received) > MAX_LOGIN_BYTES:
                problem = f"has more than {MAX_LOGIN_BYTES} bytes from the login shell before the greeting"
                raise explain_damaged_answer(self._host, "login", problem)

    def _read_log(self) -> str:
        with suppress(FileNotFoundError), (self._folder / "log").open("rb") as log:
            log.seek(max(0, os.fstat(log.fileno()).st_size - LOG_TAIL_BYTES))
            return decode_output(log.read(LOG_TAIL_BYTES))
        return ""

    def _close(self) -> None:
        """Close the stdin of ssh, and wait until ssh ends. If it does not end, terminate or kill it."""
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
