from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = ("pytester",)

CONFTEST = Path(__file__).with_name("conftest.py").read_text().replace("GRACE_S = 2.0", "GRACE_S = 0.01")

LEAKS_A_THREAD = """
    import threading
    release = threading.Event()
    def test_it():
        threading.Thread(target=release.wait, name="forgotten", daemon=True).start()
    def test_next():
        release.set()
"""

LEAKS_A_PROCESS = """
    import subprocess, sys
    kept = []
    def test_it():
        kept.append(subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE))
    def test_next():
        kept[0].communicate()
"""


def test_a_test_that_leaks_a_thread_fails(pytester: pytest.Pytester) -> None:
    _run(pytester, LEAKS_A_THREAD).stdout.fnmatch_lines("*left threads running: forgotten*")


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="this system has no /proc/self/task")
def test_a_test_that_leaks_a_child_process_fails(pytester: pytest.Pytester) -> None:
    _run(pytester, LEAKS_A_PROCESS).stdout.fnmatch_lines("*left child processes: *")


def _run(pytester: pytest.Pytester, tests: str) -> pytest.RunResult:
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(tests)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    assert result.parseoutcomes() == {"passed": 2, "errors": 1}
    return result
