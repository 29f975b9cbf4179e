"""What pip 23 and 25 printed on a Debian 12 target."""

from __future__ import annotations

import platform

import pytest

from robotcore.deploy.agent.pip_errors import explain_failure
from tests.texts import CheckText

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


HERE = (platform.python_version(), platform.machine())


@pytest.mark.parametrize(
    "printed, kind",
    [
        pytest.param(NOT_FOUND, "requirement", id="not found"),
        pytest.param(UNREACHABLE, "network", id="unreachable"),
        pytest.param(UNTRUSTED.format(why="certificate is not yet valid"), "network", id="certificate out of date"),
        pytest.param(UNTRUSTED.format(why="self-signed certificate"), "network", id="certificate untrusted"),
        pytest.param(CONTRADICTORY, "requirement", id="contradictory"),
        pytest.param(FULL, "disk", id="disk full"),
        pytest.param(UNBUILT, "wheels", id="not built"),
        pytest.param(UNPREPARED, "wheels", id="not prepared"),
        pytest.param("ERROR: Invalid requirement: 'six =='\n", "requirement", id="invalid"),
        pytest.param("Collecting six\nERROR: something new\n", "pip", id="unknown error"),
        pytest.param("Killed\n", "pip", id="no error"),
    ],
)
def test_each_failure_is_explained(printed: str, kind: str, check_text: CheckText) -> None:
    error = explain_failure(printed.splitlines(), is_offline=False)
    assert error.kind == kind
    check_text(error, hide=HERE)


def test_requirement_without_an_uploaded_wheel_is_explained_offline(check_text: CheckText) -> None:
    error = explain_failure(NOT_FOUND.splitlines(), is_offline=True)
    assert error.kind == "wheels"
    check_text(error, hide=HERE)
