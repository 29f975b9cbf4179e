"""One ssh connection for all calls and transfers, so that ssh asks for a password only once."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import tempfile
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from robotcore.deploy.errors import (
    BROKEN,
    CALL_FAILED,
    RSYNC_FAILED,
    SSH_FAILED,
    explain_damaged_answer,
    explain_failed_connection,
    find_last_line,
    require_program,
)
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.process_output import decode_output
from robotcore.errors import DeployError

if TYPE_CHECKING:
    from typing_extensions import Self

CONNECT_S, ALIVE_S, ALIVE_COUNT = 10, 5, 3
"""The options ConnectTimeout and ServerAliveInterval of ssh, in s, and ServerAliveCountMax. See ssh_config(5)."""

LOGIN_S = 150
"""The time limit of the login, in s. sshd closes a connection after 120 s, and a login shell takes some time."""

EXIT_GRACE_S = 5
"""The time that ssh may take to end, in s, before it gets the next signal."""

TERMINATE_RETRY_S = 0.2
"""The time between two SIGTERM to ssh, in s.

ssh misses a signal that comes just before it waits for a password, so the signal is repeated.
"""

BREAK_GRACE_S = 1
"""The time to wait for the end of ssh after a failed call, in s.

If the connection breaks, a call may fail shortly before ssh ends.
"""

FORWARD_ATTEMPTS = 3
"""The number of ports that are tried. Another program may take a free port before ssh does."""

SOCKET_FOLDER = "/tmp"  # noqa: S108  the socket is in a private folder in it
"""The folder for the private folder with ssh's socket.

The path of a socket must be short, and the default folder for temporary files has a long path on macOS.
"""

GREETING = b"\x1erobotcore\n"
"""The text that ``cat`` on the robot sends back. It follows the output of the login shell."""

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
"""The options that override the user's ssh configuration.

At a lower LogLevel, ssh does not print the reason of a failure. At the level INFO, it prints the robot's banner too.
"""

MAX_LOGIN_BYTES = 1 << 20
"""The greatest length of a login shell's output, in bytes."""

LOG_BLOCKS = 1 << 16
"""The greatest size of ssh's log, in blocks of 512 bytes as in POSIX's ulimit.

The log has the robot's stderr, which may be of any length. ssh ends at the limit.
"""

LOG_TAIL_BYTES = 1 << 13
"""The number of bytes at the end of the log that are read."""

LAUNCHER = ("sh", "-c", f'trap "" INT; ulimit -S -f {LOG_BLOCKS} || :; exec "$@"', "sh")
"""The command that starts ssh with a limited log and without SIGINT. After Ctrl-C, `SshConnection` closes ssh."""


class SshConnection:
    """A context manager that keeps a connection to a robot open. It raises DeployError if the robot does not answer.

    If an exception on this machine interrupts a call or a transfer over the connection, the robot ends it too.
    ``cat`` runs on the robot until its stdin is closed by this process. So ssh ends even if this process is killed.

    host: the robot.
    """

    def __init__(self, host: RobotAddress) -> None:
        self.host = host
        self._unwind = ExitStack()

    @property
    def ssh_command(self) -> list[str]:
        """The ssh command line that uses the connection, without the remote command. No part of it needs quotes."""
        return ["ssh", "-F", "none", "-S", f"{self._folder}/master", "-o", "ProxyCommand=false", "-T", "robot"]

    def __enter__(self) -> Self:
        require_program("ssh", "openssh-client")
        with ExitStack() as unwind:
            self._folder = Path(
                unwind.enter_context(tempfile.TemporaryDirectory(prefix="robotcore-ssh-", dir=SOCKET_FOLDER))
            )
            self._master = self._start()
            unwind.callback(self._close)
            self._send_greeting()
            self._unwind = unwind.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self._unwind.close()

    def reconnect(self) -> None:
        """Close the connection, and open it again."""
        self._unwind.close()
        self.__enter__()

    def find_cause(self, error: DeployError) -> DeployError:
        """Return the cause of a call's error: the broken connection if ssh has ended, else the error itself."""
        if error.kind in {CALL_FAILED, RSYNC_FAILED}:
            with suppress(subprocess.TimeoutExpired):
                self._master.wait(BREAK_GRACE_S)
                return self._explain_break()
        return error

    def forward(self, port: int) -> int:
        """Forward a free port of this machine's 127.0.0.1 to a port of the robot's 127.0.0.1, and return the free port.

        The forwarding ends with the connection. Raises DeployError if ssh refuses.
        """
        *options, name = self.ssh_command
        for _ in range(FORWARD_ATTEMPTS):
            with socket.create_server(("127.0.0.1", 0)) as listener:
                local: int = listener.getsockname()[1]
            command = [*options, "-O", "forward", "-L", f"127.0.0.1:{local}:127.0.0.1:{port}", name]
            done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603  constants and numbers
            if done.returncode == 0:
                return local
        cause = find_last_line(decode_output(done.stderr))
        text = f"{self.host}: ssh cannot forward a port: {cause}. Try again, or update ssh on this computer"
        raise self.find_cause(DeployError(text, kind=CALL_FAILED))

    def wait(self) -> None:
        """Wait until the connection breaks. Raises DeployError then."""
        self._master.wait()
        raise self._explain_break()

    def _explain_break(self) -> DeployError:
        log = self._read_log()
        words = f" ({find_last_line(log)})" if log.strip() else ""
        return DeployError(
            f"{self.host}: the connection broke{words}. Check that the robot is on and in reach, and try again",
            kind=BROKEN,
        )

    def _start(self) -> subprocess.Popen[bytes]:
        command = (*LAUNCHER, "ssh", *self._build_options(), "--", self.host.name, "cat")
        with (self._folder / "log").open("ab") as log:  # an error message quotes it
            return subprocess.Popen(  # noqa: S603  the host is validated, the rest is constant
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log
            )

    def _build_options(self) -> list[str]:
        host = self.host
        options = MASTER_OPTIONS | ({} if _can_ask_user() else {"BatchMode": "yes"})
        return [
            *("-S", f"{self._folder}/master", "-E", f"{self._folder}/log", "-T"),
            *(("-F", str(host.ssh_config)) if host.ssh_config else ()),
            *(("-l", host.user) if host.user else ()),
            *(("-p", str(host.port)) if host.port else ()),
            *(part for name, value in options.items() for part in ("-o", f"{name}={value}")),
        ]

    def _send_greeting(self) -> None:
        assert self._master.stdin
        assert self._master.stdout
        with suppress(BrokenPipeError):
            self._master.stdin.write(GREETING)
            self._master.stdin.flush()
        try:
            self._await_greeting(self._master.stdout.fileno())
        except BaseException:
            # after SIGKILL while ssh asks for a password, the terminal would no longer echo input
            for _ in range(int(EXIT_GRACE_S / TERMINATE_RETRY_S)):
                self._master.terminate()
                with suppress(subprocess.TimeoutExpired):
                    self._master.wait(TERMINATE_RETRY_S)
                    break
            raise

    def _await_greeting(self, answers: int) -> None:
        received = b""
        while not received.endswith(GREETING):
            if not select.select([answers], [], [], LOGIN_S)[0]:
                raise DeployError(
                    f"{self.host}: the robot sent nothing within {LOGIN_S:g} s of the login. Check whether its login "
                    f"shell waits for input: ssh {self.host.login}",
                    kind="login-time-out",
                    limit_s=LOGIN_S,
                )
            if not (more := os.read(answers, 4096)):
                status = self._master.wait()
                said = self._read_log() if status == SSH_FAILED else decode_output(received[-LOG_TAIL_BYTES:])
                raise explain_failed_connection(self.host, status, said)
            received += more
            if len(received) > MAX_LOGIN_BYTES:
                problem = f"has more than {MAX_LOGIN_BYTES} bytes from the login shell before the greeting"
                raise explain_damaged_answer(self.host, "login", problem)

    def _read_log(self) -> str:
        with suppress(FileNotFoundError), (self._folder / "log").open("rb") as log:
            log.seek(max(0, os.fstat(log.fileno()).st_size - LOG_TAIL_BYTES))
            return decode_output(log.read(LOG_TAIL_BYTES))
        return ""

    def _close(self) -> None:
        with self._master as master:
            assert master.stdin
            with suppress(BrokenPipeError):
                master.stdin.close()
            for end in (master.terminate, master.kill):
                with suppress(subprocess.TimeoutExpired):
                    master.wait(EXIT_GRACE_S)
                    return
                end()


def _can_ask_user() -> bool:
    if os.environ.get("SSH_ASKPASS"):
        return True
    with suppress(OSError):
        os.close(os.open("/dev/tty", os.O_RDWR | os.O_NOCTTY))
        return True
    return False
