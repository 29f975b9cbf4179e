"""The real-time priority of a run's ticks (``--rt``), and the protection of the machine from an app that hangs with it.

Linux alone has these calls. The modules for them are imported where they are used, so that other systems can import
this one.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcore.errors import UsageError
from robotcore.system import IS_LINUX
from robotcore.threads import StoppingThread

TICK_PRIORITY, STOP_PRIORITY = 20, 30
"""The priorities of the tick's thread, and of everything that stops the motors: guardian, deadman and watchdog.

The kernel's own threads for interrupts have 50. Source: Linux, kernel/sched/core.c, sched_set_fifo.
"""

HANG_S, KILL_S = 1.0, 5.0
"""The longest step of an app with real-time priority, and the longest use of a processor without a pause, in seconds.

After `HANG_S` the run loses its priority: the watchdog takes it away, or the signal SIGXCPU. After `KILL_S` the kernel
ends the process, because Python did not act: a call in C holds the interpreter's lock. The guardian then stops the
motors.
"""

_ALL_MEMORY = 1 | 2 | 4
"""MCL_CURRENT, MCL_FUTURE and MCL_ONFAULT of mlockall(2): lock present and future pages as soon as they are used."""

_MAY_LOCK = 1 << 14
"""CAP_IPC_LOCK in the field CapEff of proc_pid_status(5)."""

NO_GUARDIAN = (
    "--rt: no real-time priority, because no guardian guards the motors of this robot. The kernel would end a hung "
    "run, and nothing would stop them. Let the drivers of the motors describe cutoffs"
)

REMEDY = (
    "Write two lines with your user's name into /etc/security/limits.d/robotcore.conf, and log in again: "
    f"'USER - rtprio {STOP_PRIORITY}' and 'USER - memlock unlimited'. For a service of systemd: "
    f'LimitRTPRIO={STOP_PRIORITY} and LimitMEMLOCK=infinity, see the page "Safety" of the documentation'
)


_OTHER_PYTHON = "Leave --rt out, or use the Python of Debian"


def require_real_time() -> None:
    """Raise UsageError if this system, its Python or its C library has no real-time priorities."""
    if not IS_LINUX:
        text = f"--rt needs Linux, and this system is {sys.platform}. Leave --rt out"
    elif not hasattr(os, "sched_setscheduler"):
        text = f"--rt needs os.sched_setscheduler, and this Python lacks it. {_OTHER_PYTHON}"
    elif not _has_scheduler():
        text = f"--rt needs sched_setscheduler, which this system lacks or forbids, such as with musl. {_OTHER_PYTHON}"
    else:
        return
    raise UsageError(text, kind="no-real-time", system=sys.platform)


def _has_scheduler() -> bool:
    if not hasattr(os, "sched_getscheduler"):
        return False
    try:
        os.sched_getscheduler(0)
    except OSError:  # the C library lacks it, or a filter of system calls forbids it
        return False
    return True


@dataclass(frozen=True)
class Priorities:
    """The priorities that the system grants, from 1 to 99."""

    tick: int
    stop: int


def find_priorities() -> tuple[Priorities | None, str]:
    """Return the priorities that this process may use, and an empty text; or None, and the reason with a remedy.

    It raises the soft limit RTPRIO to the hard limit. The thread keeps its own priority.
    """
    if len(os.sched_getaffinity(0)) < 2:
        return None, "--rt: no real-time priority, because the run has one processor only. A hung app would block it"
    if threading.current_thread() is not threading.main_thread():
        return None, "--rt: no real-time priority, because the run is not in the main thread. Run it there"
    import resource

    _raise_soft_limit(resource.RLIMIT_RTPRIO)
    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    for stop in dict.fromkeys((STOP_PRIORITY, min(limit, STOP_PRIORITY))):
        if stop >= 2 and _is_priority_granted(stop):
            return Priorities(max(1, stop - (STOP_PRIORITY - TICK_PRIORITY)), stop), ""
    return None, f"--rt: no real-time priority, because the limit RTPRIO of this user is {limit}. {REMEDY}"


def _is_priority_granted(priority: int) -> bool:
    own_policy = read_policy()
    try:
        set_priority(0, priority)
    except PermissionError:
        return False
    restore_policy(own_policy)
    return True


def read_policy() -> tuple[int, int]:
    """Return the scheduling policy and the priority of the calling thread."""
    return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(0).sched_priority


def restore_policy(policy: tuple[int, int]) -> None:
    """Give the calling thread the policy and the priority that `read_policy` has returned."""
    os.sched_setscheduler(0, policy[0] | os.SCHED_RESET_ON_FORK, os.sched_param(policy[1]))


def set_priority(thread: int, priority: int) -> None:
    """Give a thread or the main thread of a process a real-time priority. Raises PermissionError.

    thread: its number in the system; 0 for the calling thread.

    Threads and processes that it starts later have no such priority.
    """
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    os.sched_setscheduler(thread, policy, os.sched_param(priority))


def drop_priority(thread: int) -> None:
    """Give a thread the normal priority."""
    # Without the flag, the call needs a right that an ordinary user lacks.
    os.sched_setscheduler(thread, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))


def set_process_priority(process: int, priority: int) -> None:
    """Give a process a real-time priority, also to its later threads. Raises PermissionError, ProcessLookupError."""
    os.sched_setscheduler(process, os.SCHED_FIFO, os.sched_param(priority))


def lock_memory() -> str:
    """Lock this process's memory into RAM, so that no page is read from the disk again. Return the problem, if any.

    Pages that were never used take no RAM. With a limit of locked memory, nothing is locked: later, the system would
    refuse the app new memory.
    """
    import ctypes
    import resource

    memlock = 8  # RLIMIT_MEMLOCK, which Python's module does not name before 3.12
    memlock = getattr(resource, "RLIMIT_MEMLOCK", memlock)
    _raise_soft_limit(memlock)
    limit = resource.getrlimit(memlock)[0]
    if limit != resource.RLIM_INFINITY and not _has_lock_right():
        return f"--rt: the memory is not locked, because the limit MEMLOCK of this user is {limit >> 10} KB. {REMEDY}"
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_ALL_MEMORY):
        return f"--rt: the memory is not locked: {os.strerror(ctypes.get_errno())}. {REMEDY}"
    return ""


def unlock_memory() -> None:
    """Undo `lock_memory`."""
    import ctypes

    ctypes.CDLL(None).munlockall()


def _has_lock_right() -> bool:
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    rights = next((int(line.split()[1], 16) for line in lines if line.startswith("CapEff:")), 0)
    return bool(rights & _MAY_LOCK)


def _raise_soft_limit(which: int) -> None:
    import resource

    with suppress(OSError, ValueError):
        hard = resource.getrlimit(which)[1]
        resource.setrlimit(which, (hard, hard))


class RealTimeTicks:
    """Locks the memory, and gives the tick's thread a real-time priority from the end of the first tick on.

    In the first tick an app may import libraries and load models. Nothing moves yet.

    report: a function that gets a note if something is refused, or if the app has lost the priority.
    has_guardian: whether a guardian stops the motors if the kernel ends the process. Without one, the run has no
        priority.
    """

    def __init__(self, report: Callable[[str], object], *, has_guardian: bool) -> None:
        self._report = report
        self.priorities, problem = find_priorities() if has_guardian else (None, NO_GUARDIAN)
        """The granted priorities; None if the system grants none."""
        if refused := lock_memory():
            problem = problem.removesuffix(f". {REMEDY}")  # the second note has it
        for note in filter(None, (problem, refused)):
            report(note)
        self._threads: list[int] = []
        """The threads that have a real-time priority, by their numbers in the system."""
        self._own_policy = (0, 0)
        """The policy and the priority of the tick's thread before."""
        self._before: tuple[Any, tuple[int, int]] | None = None
        """The handler of SIGXCPU and the limits RTTIME before, while the priority may be in force."""

    def begin_after_first_tick(self, _record: object) -> None:
        """Begin at the first call. The loop calls it at the end of each tick, in the tick's thread."""
        if self._before is None and self.priorities:
            self._own_policy = read_policy()
            self._limit_hangs()
            for thread in threading.enumerate():
                if isinstance(thread, StoppingThread) and thread.native_id:
                    self._set_priority(thread.native_id, self.priorities.stop)
            self._set_priority(threading.get_native_id(), self.priorities.tick)

    def end(self) -> None:
        """Return to the normal priority, and unlock the memory. A second call does nothing."""
        unlock_memory()
        self._drop_priorities()
        if self._before:
            import resource

            if self._own_policy[0] != os.SCHED_OTHER:
                restore_policy(self._own_policy)
            handler, limits = self._before
            self._before = self.priorities = None
            hard = resource.getrlimit(resource.RLIMIT_RTTIME)[1]
            try:
                resource.setrlimit(resource.RLIMIT_RTTIME, limits)
            except (OSError, ValueError):  # only root may raise the hard limit again
                resource.setrlimit(resource.RLIMIT_RTTIME, (_find_lower_limit(limits[0], hard), hard))
            signal.signal(signal.SIGXCPU, handler)

    def _set_priority(self, thread: int, priority: int) -> None:
        with suppress(ProcessLookupError):  # it has just ended
            set_priority(thread, priority)
            self._threads.append(thread)

    def _drop_priorities(self) -> None:
        while self._threads:
            with suppress(ProcessLookupError, IndexError):  # the watchdog's thread may take the last one
                drop_priority(self._threads.pop())

    def _limit_hangs(self) -> None:
        import resource

        limits = resource.getrlimit(resource.RLIMIT_RTTIME)
        self._before = signal.signal(signal.SIGXCPU, self.drop_priority_of_run), limits
        hard = _find_lower_limit(limits[1], int(KILL_S * 1e6))
        resource.setrlimit(resource.RLIMIT_RTTIME, (_find_lower_limit(int(HANG_S * 1e6), hard), hard))

    def drop_priority_of_run(self, *_: object) -> None:
        """Return to the normal priority for the rest of the run, and report it. Any thread may call it."""
        if self._threads:
            self._drop_priorities()
            self._report(
                f"--rt: a tick took longer than {HANG_S:g} s, so the run goes on with the normal priority. Let the "
                "app's step return in time"
            )


def _find_lower_limit(first: int, second: int) -> int:
    limits: Iterable[int] = (limit for limit in (first, second) if limit >= 0)  # -1 is no limit
    return min(limits, default=-1)


def read_priority_and_locked_memory() -> dict[str, int]:
    """Return the real-time priority of this thread, 0 for the normal one, and the locked memory of the process in KB.

    Both are 0 on a system without real-time priorities.
    """
    if not _has_scheduler():
        return {"priority": 0, "locked_kb": 0}
    is_real_time = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    locked = next((int(line.split()[1]) for line in lines if line.startswith("VmLck:")), 0)
    return {"priority": os.sched_getparam(0).sched_priority if is_real_time else 0, "locked_kb": locked}
