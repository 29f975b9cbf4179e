"""The versions of Python that robotcore supports, and the message for a Python that is too old.

Python 3.6 and newer can parse this module and ``robotcore/__init__.py``, which is imported first.
"""

import sys

MIN_PYTHON, MAX_PYTHON = (3, 10), (3, 13)
"""The oldest and the newest version of Python with which robotcore is tested."""

USAGE_STATUS = 2
"""The exit status of a command that cannot run, as of a UsageError."""


def require_supported_python() -> None:
    """End the process with a message of one line if this Python is too old.

    pip refuses to install robotcore there. A checkout, or ``pip install --ignore-requires-python``, passes pip by.
    """
    if sys.version_info[:2] < MIN_PYTHON:
        oldest = ".".join(map(str, MIN_PYTHON))
        sys.stderr.write(
            f"error: robotcore needs Python {oldest} or newer, and {sys.executable} is Python "
            f"{sys.version.split()[0]}. Install a newer Python, and make an environment with it: "
            f"python{oldest} -m venv .venv\n"
        )
        sys.exit(USAGE_STATUS)
