"""What pip 23 and 25 printed on a Debian 12 target."""

from __future__ import annotations

import pytest

from robotcore.deploy.agent.pip_errors import explain_failure

NOT_FOUND = """\
ERROR: Could not find a version that satisfies the requirement six==99 (from versions: 1.16.0, 1.17.0)
ERROR: No matching distribution found for six==99
"""
UNREACHABLE = """\
WARNING: Retrying (Retry(total=0, connect=None, read=None, redirect=None, status=None)) after connection broken by \
'NewConnectionError('<pip._vendor.urllib3.connection.HTTPSConnection object at 0x7f9b030513d0>: Failed to establish a \
new connection: [Errno -2] Name or service not known')': /simple/six/
ERROR: Could not find a version that satisfies the requirement six (from versions: none)
ERROR: No matching distribution found for six
"""
UNTRUSTED = """\
Could not fetch URL https://index.example/simple/six/: There was a problem confirming the ssl certificate: \
HTTPSConnectionPool(host='index.example', port=443): Max retries exceeded with url: /simple/six/ (Caused by \
SSLError(SSLCertVerificationError(1, '[SSL: CERTIFICATE_VERIFY_FAILED] certificate verify failed: {why} \
(_ssl.c:992)'))) - skipping
ERROR: No matching distribution found for six
"""
CONTRADICTORY = """\
ERROR: Cannot install six==1.15 and six==1.16 because these package versions have conflicting dependencies.
ERROR: ResolutionImpossible: for help visit the documentation
"""
FULL = """\
Installing collected packages: numpy
ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device
"""
UNBUILT = """\
Collecting six
Collecting lgpio==0.2.2.0
  Running setup.py install for lgpio: finished with status 'error'
  error: subprocess-exited-with-error
  \u00d7 Running setup.py install for lgpio did not run successfully.
  \u2570\u2500> [10 lines of output]
      swig -python -o lgpio_wrap.c lgpio.i
      error: command 'swig' failed: No such file or directory
      [end of output]
error: legacy-install-failure
\u2570\u2500> lgpio
"""
UNPREPARED = """\
Collecting numpy==1.19.5
  Preparing metadata (pyproject.toml): finished with status 'error'
  error: subprocess-exited-with-error
      RuntimeError: Broken toolchain: cannot link a simple C program
      [end of output]
error: metadata-generation-failed
\u2570\u2500> See above for output.
"""


@pytest.mark.parametrize(
    "printed, kind, fault",
    [
        (NOT_FOUND, "requirement", "there is no six==99 for Python "),
        (UNREACHABLE, "network", "the robot does not reach the package index"),
        (UNTRUSTED.format(why="certificate is not yet valid"), "network", "certificate is out of date"),
        (UNTRUSTED.format(why="self-signed certificate"), "network", "does not trust who answers"),
        (CONTRADICTORY, "requirement", "contradict each other"),
        (FULL, "disk", "the robot's disk is full"),
        (UNBUILT, "wheels", "lgpio has no wheel for Python "),
        (UNBUILT, "wheels", "cannot be built there: error: command 'swig' failed: No such file or directory"),
        (UNPREPARED, "wheels", "numpy has no wheel for Python "),
        ("ERROR: Invalid requirement: 'six =='\n", "requirement", "six == is no requirement"),
        ("Collecting six\nERROR: something new\n", "pip", "pip failed on the robot: something new"),
        ("Killed\n", "pip", "pip failed on the robot: Killed"),
    ],
)
def test_each_failure_is_told_for_what_it_is(printed: str, kind: str, fault: str) -> None:
    refusal = explain_failure(printed.splitlines(), is_offline=False)
    assert (refusal.kind, fault in refusal.fault) == (kind, True), str(refusal)
    assert refusal.remedy


def test_without_a_network_what_is_missing_was_not_brought() -> None:
    refusal = explain_failure(NOT_FOUND.splitlines(), is_offline=True)
    assert refusal.kind == "wheels"
    assert refusal.fault.startswith("no six==99 for Python ")
