from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, suppress
from importlib.metadata import EntryPoint
from pathlib import Path
from time import monotonic, sleep

import pytest

from benchmarks.logging_robot import LoggingBackend
from robotcore import RunRequest, plugins, run
from robotcore.cli.main import execute
from robotcore.errors import UsageError
from robotcore.runtime.behaviour import Status
from robotcore.runtime.plan import Plan
from robotcore.runtime.result import RealTimeNote
from robotcore.safety import real_time
from robotcore.safety.real_time import (
    NO_GUARDIAN,
    Priorities,
    RealTimeTicks,
    drop_priority,
    find_priorities,
    lock_memory,
    read_priority_and_locked_memory,
    require_real_time,
    set_priority,
    unlock_memory,
)
from robotcore.threads import start_thread
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.safety.guardian.recorder import notes
from tests.texts import CheckText, Raises

linux = pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="needs Linux")
ROOT = Path(__file__).parents[3]


def _is_granted() -> bool:
    return hasattr(os, "sched_setscheduler") and find_priorities()[0] == Priorities(20, 30)


def _may_lock() -> bool:
    if not hasattr(os, "sched_setscheduler"):
        return False
    is_refused = lock_memory()
    unlock_memory()
    return not is_refused


may_lock = pytest.mark.skipif(not _may_lock(), reason="this user may not lock memory")
granted = pytest.mark.skipif(not _is_granted(), reason="this user has no real-time priority")


def test_another_system_than_linux_is_a_usage_error(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr("sys.platform", "darwin")
    monkeypatch.setattr(real_time, "IS_LINUX", False)
    with raises(UsageError, "no-real-time", system="darwin") as raised:
        require_real_time()
    page = " ".join((ROOT / "docs" / "systems.md").read_text(encoding="utf-8").split())
    assert isinstance(raised.value, UsageError)
    assert f"a `UsageError` with the kind `no-real-time` and exit status {raised.value.exit_status}" in page


@linux
def test_a_python_without_the_calls_of_the_scheduler_is_a_usage_error(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    with raises(UsageError, "no-real-time", system="linux"):
        require_real_time()


@linux
def test_a_c_library_without_the_calls_of_the_scheduler_is_a_usage_error(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    """The functions of musl always fail with ENOSYS. The guardian asks for its priority in each run."""

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))

    for name in ("sched_getscheduler", "sched_setscheduler", "sched_getparam", "sched_setparam"):
        monkeypatch.setattr(os, name, fail)
    with raises(UsageError, "no-real-time", system="linux"):
        require_real_time()
    assert read_priority_and_locked_memory() == {"priority": 0, "locked_kb": 0}


def test_a_simulator_in_lockstep_refuses_rt(raises: Raises) -> None:
    with raises(UsageError, "rt-without-real-time", backend="kinematic"):
        Plan.resolve(RunRequest("green-search", has_real_time_priority=True))


@linux
def test_without_permission_the_note_has_the_limit_and_the_remedy(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    import resource

    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(real_time, "set_priority", refuse)
    monkeypatch.setattr(real_time, "_has_lock_right", lambda: False)
    monkeypatch.setattr(real_time, "_raise_soft_limit", lambda _: None)
    monkeypatch.setattr(
        resource, "getrlimit", lambda which: (0, 0) if which == resource.RLIMIT_RTPRIO else (8 << 20, 8)
    )
    notes: list[str] = []
    with closing(_Closed(RealTimeTicks(notes.append, has_guardian=True))) as ticks:
        assert ticks.priorities is None
    check_text("\n".join(notes))


@linux
def test_with_one_processor_no_priority_is_taken(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    found, reason = find_priorities()
    assert found is None
    check_text(reason)


@linux
def test_without_a_guardian_no_priority_is_taken(check_text: CheckText) -> None:
    notes: list[str] = []
    with closing(_Closed(RealTimeTicks(notes.append, has_guardian=False))) as ticks:
        assert ticks.priorities is None
    check_text(notes[0])


@linux
def test_a_run_without_the_priority_has_a_note_of_its_own_type(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.runtime.plan.load_backend", lambda _: LoggingBackend())
    app = FunctionApp(lambda _: Status.SUCCESS)
    result = run(RunRequest(app, "logging", options={"diary": str(tmp_path / "diary")}, has_real_time_priority=True))
    assert NO_GUARDIAN in [note for note in result.notes if isinstance(note, RealTimeNote)]


class _Closed:
    """Closes `RealTimeTicks`."""

    def __init__(self, ticks: RealTimeTicks) -> None:
        self.priorities, self._ticks = ticks.priorities, ticks

    def close(self) -> None:
        self._ticks.end()


@granted
def test_a_policy_that_the_process_had_before_is_restored() -> None:
    set_priority(0, 10)
    try:
        ticks = RealTimeTicks(print, has_guardian=True)
        assert read_priority_and_locked_memory()["priority"] == 10
        ticks.begin_after_first_tick(None)
        assert read_priority_and_locked_memory()["priority"] == 20
        ticks.end()
        assert read_priority_and_locked_memory()["priority"] == 10
    finally:
        drop_priority(0)


@granted
def test_the_tick_has_its_priority_until_the_end_and_the_threads_that_stop_motors_have_a_higher_one() -> None:
    import resource

    soft, handler = resource.getrlimit(resource.RLIMIT_RTTIME)[0], signal.getsignal(signal.SIGXCPU)
    is_over = threading.Event()
    watchdog = start_thread(is_over.wait, "a stop", stops_motors=True)
    other = start_thread(is_over.wait, "watchdog")
    ticks = RealTimeTicks(print, has_guardian=True)
    try:
        assert read_priority_and_locked_memory()["priority"] == 0
        ticks.begin_after_first_tick(None)
        assert read_priority_and_locked_memory()["priority"] == 20
        assert read_priority_and_locked_memory()["locked_kb"] > 0
        assert [_priority(thread) for thread in (watchdog, other)] == [30, 0]
        late = threading.Thread(target=is_over.wait)
        late.start()
        assert _priority(late) == 0
    finally:
        ticks.end()
        is_over.set()
    assert read_priority_and_locked_memory() == {"priority": 0, "locked_kb": 0}
    assert signal.getsignal(signal.SIGXCPU) is handler
    assert resource.getrlimit(resource.RLIMIT_RTTIME)[0] in (soft, 5_000_000)  # an ordinary user cannot raise it again
    for thread in (watchdog, other, late):
        thread.join()


def _priority(thread: threading.Thread) -> int:
    assert thread.native_id
    return os.sched_getparam(thread.native_id).sched_priority


@pytest.fixture
def hung() -> Iterator[subprocess.Popen[str]]:
    """Start a run with real-time priority whose app hangs; it notes its actions in lines of JSON."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.robotcore.safety.hung_real_time_run"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.PIPE,
        text=True,
    ) as process:
        yield process
        process.kill()


def read_children(parent: int) -> list[dict[str, str]]:
    """Return the fields of proc_pid_status(5) of each child process."""
    found = []
    for file in Path("/proc").glob("[0-9]*/status"):
        with suppress(OSError):  # the process has just ended
            lines = file.read_text().splitlines()
            found += [{name: value.strip() for name, _, value in (line.partition(":") for line in lines)}]
    return [each for each in found if each.get("PPid") == str(parent)]


@granted
@pytest.mark.slow
def test_an_app_that_computes_without_end_loses_its_priority_and_the_watchdog_ends_it(
    hung: subprocess.Popen[str],
) -> None:
    """The deadman stops the motors first, while the app still has real-time priority."""
    out, err = hung.communicate("python\n", timeout=60)
    events = [json.loads(line) for line in out.splitlines()]
    assert events[-1]["outcome"] == "stopped", err
    assert any("--rt: a tick took longer" in note for note in events[-1]["notes"])
    assert events[-1]["stopped_s"] < 0.5


@granted
@may_lock
@pytest.mark.slow
def test_the_memory_of_the_guardian_of_a_run_with_real_time_priority_is_locked(hung: subprocess.Popen[str]) -> None:
    assert hung.stdin
    assert hung.stdout
    hung.stdin.write("python\n")
    hung.stdin.flush()
    begin = json.loads(hung.stdout.readline())
    (guardian,) = read_children(hung.pid)
    hung.kill()
    hung.communicate(timeout=60)  # until the guardian has ended too
    shutil.rmtree(Path(begin["diary"]).parent)
    assert int(guardian["VmLck"].removesuffix(" kB")) > 0


@granted
@pytest.mark.slow
def test_an_app_that_blocks_the_interpreter_at_real_time_priority_is_killed_and_other_programs_run(
    hung: subprocess.Popen[str],
) -> None:
    """The guardian notes its stop before the kernel kills the app: it has a higher priority."""
    assert hung.stdin
    assert hung.stdout
    hung.stdin.write("c\n")
    hung.stdin.flush()
    begin = json.loads(hung.stdout.readline())
    assert begin["event"] == "hangs"
    start = monotonic()
    waits = []
    while hung.poll() is None and monotonic() - start < 30:
        before = monotonic()
        subprocess.run(["/bin/true"], check=True)  # what sshd does at a login
        waits.append(monotonic() - before)
        sleep(0.1)
    assert hung.returncode == -signal.SIGKILL
    assert monotonic() - start < 15
    assert max(waits) < 3
    diary = Path(begin["diary"])
    stops = [note.time for note in notes(diary) if note.action.startswith("stop") and note.time > begin["time"]]
    shutil.rmtree(diary.parent)
    assert min(stops) - begin["time"] < 2


@granted
@pytest.mark.slow
def test_a_recorded_run_with_real_time_priority_replays_to_the_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    registered = plugins._points
    logging = EntryPoint("logging", "benchmarks.logging_robot:LoggingBackend", plugins.BACKENDS)
    monkeypatch.setattr(
        plugins,
        "_points",
        lambda group: {**registered(group), **({"logging": logging} if group == plugins.BACKENDS else {})},
    )
    file, diary = str(tmp_path / "run.mcap"), f"diary={tmp_path / 'diary'}"
    run = ["run", "mark-green", "--backend", "logging", "--option", diary, "--timeout", "1", "--rt", "--record", file]
    assert execute(run) == 1  # a timeout
    assert execute(["replay", file]) == 0
