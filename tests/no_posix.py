"""Hides from the project's own code what Windows lacks: ``pytest -p tests.no_posix``.

The code of robotcore, drivers and apps then gets ModuleNotFoundError for a module such as fcntl, AttributeError for a
name such as ``os.fork``, and the errors of Windows for some calls: `select` of a pipe, a rename over a file, the
removal of an open file, and a process that inherits handles. The standard library, other libraries and the tests keep
all of them. The same holds in each child process. New processes of `multiprocessing` are spawned.

This is no Windows: its clock, its paths and its console are those of this system.
"""

from __future__ import annotations

import atexit
import builtins
import os
import pathlib
import select
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable
from types import ModuleType
from typing import Any

PACKAGES = {"robotcore", "drivers", "apps"}

MODULES = {"fcntl", "termios", "resource", "pty", "tty", "pwd", "grp", "crypt", "syslog", "curses", "readline"}

NAMES = {
    "os": """
        fork forkpty register_at_fork set_blocking get_blocking killpg getpgid getpgrp setpgid setsid getsid
        getuid geteuid getgid getegid getgroups sched_getaffinity sched_setaffinity sched_yield
        sched_setscheduler sched_getscheduler sched_getparam sched_param SCHED_FIFO nice mkfifo mknod fchmod
        fchown chown chroot fchdir fstatvfs statvfs openpty ttyname tcgetpgrp tcsetpgrp major minor makedev
        pread pwrite memfd_create pidfd_open wait wait3 wait4 waitid WIFEXITED WIFSIGNALED WEXITSTATUS WTERMSIG
        WNOHANG O_NONBLOCK O_NOCTTY O_NOFOLLOW O_DIRECTORY O_CLOEXEC O_SYNC uname getloadavg sysconf confstr
        ctermid sendfile posix_spawn getpriority setpriority getxattr setxattr""",
    "signal": """
        SIGHUP SIGQUIT SIGKILL SIGALRM SIGUSR1 SIGUSR2 SIGCHLD SIGCONT SIGSTOP SIGTSTP SIGTTIN SIGTTOU SIGURG
        SIGPIPE SIGXCPU SIGWINCH SIGRTMIN SIGRTMAX SIG_BLOCK SIG_UNBLOCK SIG_SETMASK ITIMER_REAL pthread_kill
        pthread_sigmask setitimer getitimer alarm pause sigwait sigwaitinfo sigtimedwait sigpending siginterrupt
        pidfd_send_signal""",
    "socket": """
        AF_UNIX AF_NETLINK AF_CAN AF_PACKET SOCK_SEQPACKET MSG_DONTWAIT MSG_NOSIGNAL SCM_RIGHTS SO_REUSEPORT
        send_fds recv_fds sethostname""",
    "select": "poll epoll kqueue EPOLLIN POLLIN POLLOUT POLLHUP",
}
"""The names of each module that Python for Windows lacks. Source: docs.python.org, the remarks on availability."""

_real_import = builtins.__import__


def is_project(name: object) -> bool:
    """Return whether a module's name is that of a module of the project."""
    return str(name).partition(".")[0] in PACKAGES


def _is_called_by_project() -> bool:
    """Return whether the innermost caller outside of the standard library's wrappers is a module of the project."""
    frame = sys._getframe(2)
    while frame.f_back and frame.f_globals.get("__name__") in {__name__, "pathlib", "pathlib._local", "subprocess"}:
        frame = frame.f_back
    return is_project(frame.f_globals.get("__name__"))


class Facade(ModuleType):
    """A module without the names that Windows lacks. Other names are read from and written to the real module."""

    def __init__(self, real: ModuleType, replaced: dict[str, Any]) -> None:
        super().__init__(real.__name__)
        vars(self).update(_real=real, _replaced=replaced, _hidden=set(NAMES[real.__name__].split()))

    def __getattr__(self, name: str) -> Any:
        real = vars(self)["_real"]
        if name in vars(self)["_hidden"]:
            raise AttributeError(f"module {real.__name__!r} of Windows has no attribute {name!r}")
        return vars(self)["_replaced"].get(name) or getattr(real, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(vars(self)["_real"], name, value)

    def __delattr__(self, name: str) -> None:
        delattr(vars(self)["_real"], name)


def select_sockets(*files_and_timeout: Any) -> Any:
    """Call `select` as on Windows, which accepts sockets only, and at least one of them."""
    *files, timeout = files_and_timeout if len(files_and_timeout) > 3 else (*files_and_timeout, None)
    numbers = [each if isinstance(each, int) else each.fileno() for group in files for each in group]
    if not numbers or any(not stat.S_ISSOCK(os.fstat(number).st_mode) for number in numbers):
        raise OSError(10038, "an operation was attempted on something that is not a socket")
    read, write, failing = files
    return select.select(read, write, failing, timeout)


class Msvcrt(ModuleType):
    """The part of Windows' module msvcrt that the project uses. A lock belongs to the open file, as on Windows."""

    LK_NBLCK = 2

    @staticmethod
    def locking(descriptor: int, mode: int, size: int) -> None:
        import fcntl
        import struct

        at = os.lseek(descriptor, 0, os.SEEK_CUR)
        lock = struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, at, size, 0)
        try:
            fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, lock)
        except BlockingIOError:
            raise PermissionError(13, "Permission denied") from None


def _is_open(path: Any) -> bool:
    """Return whether this process has a regular file open, so that Windows would not remove or replace it."""
    try:
        wanted = pathlib.Path(path).stat()
        opened = list(pathlib.Path("/proc/self/fd").iterdir())
    except OSError:
        return False
    for number in opened:
        try:
            found = number.stat()
        except OSError:
            continue
        if stat.S_ISREG(found.st_mode) and os.path.samestat(found, wanted):
            return True
    return False


def _check_removal(path: Any) -> None:
    if _is_open(path):
        raise PermissionError(13, "the file is open, so Windows does not remove or replace it", str(path))


def _wrap_removal(real: Callable[..., Any], *, is_replacing_allowed: bool) -> Callable[..., Any]:
    def call(path: Any, *arguments: Any, **options: Any) -> Any:
        if _is_called_by_project():
            _check_removal(path)
            if arguments and os.path.lexists(arguments[0]) and not pathlib.Path(path).samefile(arguments[0]):
                if not is_replacing_allowed:
                    raise FileExistsError(17, "the file exists, so Windows renames no other to it", str(path))
                _check_removal(arguments[0])
        return real(path, *arguments, **options)

    return call


def _wrap_popen(real: Callable[..., None]) -> Callable[..., None]:
    def start(self: Any, args: Any, *others: Any, **options: Any) -> None:
        if _is_called_by_project():
            for name in ("pass_fds", "preexec_fn"):
                if options.get(name):
                    raise ValueError(f"{name} is not supported on Windows platforms")
        if isinstance(args, (list, tuple)) and "-I" in args and "-c" in args:  # an isolated Python reads no PYTHONPATH
            at = list(args).index("-c") + 1
            prefix = f"import runpy; runpy.run_path({__file__!r})['hide'](); "
            args = [*args[:at], prefix + args[at], *args[at + 1 :]]
        real(self, args, *others, **options)

    return start


def hide() -> None:
    """Hide the modules and the names in this process. A second call does nothing."""
    if getattr(builtins, "_is_posix_hidden", False):
        return
    builtins._is_posix_hidden = True  # type: ignore[attr-defined]
    removals = {
        "unlink": _wrap_removal(os.unlink, is_replacing_allowed=True),
        "remove": _wrap_removal(os.remove, is_replacing_allowed=True),
        "replace": _wrap_removal(os.replace, is_replacing_allowed=True),
        "rename": _wrap_removal(os.rename, is_replacing_allowed=False),
    }
    facades = {
        "os": Facade(os, removals),
        "signal": Facade(signal, {}),
        "socket": Facade(socket, {}),
        "select": Facade(select, {"select": select_sockets}),
        "msvcrt": Msvcrt("msvcrt"),
    }

    def import_module(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:  # noqa: A002  as in `__import__`
        root = name.partition(".")[0]
        if level == 0 and (root in MODULES or root in facades) and is_project((globals or {}).get("__name__")):
            if root in MODULES:
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
            if "." not in name or not fromlist:
                return facades[root]
        return _real_import(name, globals, locals, fromlist, level)

    builtins.__import__ = import_module
    for name in ("unlink", "rename", "replace"):
        real = getattr(pathlib.Path, name)
        setattr(pathlib.Path, name, _wrap_removal(real, is_replacing_allowed=name != "rename"))
    subprocess.Popen.__init__ = _wrap_popen(subprocess.Popen.__init__)  # type: ignore[method-assign]


def _hide_in_children() -> None:
    """Let each Python that inherits this environment hide them too, by a sitecustomize."""
    folder = tempfile.mkdtemp(prefix="no-posix-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    code = f"import runpy\nrunpy.run_path({__file__!r})['hide']()\n"
    pathlib.Path(folder, "sitecustomize.py").write_text(code, encoding="utf-8")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (folder, os.environ.get("PYTHONPATH"))))


if __name__ == "tests.no_posix":
    import multiprocessing
    from multiprocessing import resource_tracker

    assert "robotcore" not in sys.modules, "the plug-in must be loaded before the project: use pytest -p tests.no_posix"
    _hide_in_children()
    hide()
    multiprocessing.set_start_method("spawn")
    resource_tracker.ensure_running()  # a process of POSIX, which else the first test with a pool would leave
