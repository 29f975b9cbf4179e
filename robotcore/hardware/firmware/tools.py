"""Running the tools that build and flash, and saying what they said."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from robotcore.errors import FirmwareError


def found(*names: str) -> bool:
    """Return whether all these programs are on the PATH."""
    return all(map(shutil.which, names))


def run(command: Sequence[str | Path], doing: str, remedy: str = "", timeout: float = 300.0) -> str:
    """Run a tool to its end; return what it printed, on stdout and stderr.

    Raises FirmwareError with the words of a tool that fails, and the remedy, or where it has not ended after
    ``timeout`` seconds.
    """
    tool = Path(command[0]).name
    try:
        ran = subprocess.run(  # noqa: S603  a tool by its name, with arguments of ours, and no shell
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FirmwareError(f"{doing}: {tool} had not ended after {timeout:g} s, and was killed") from error
    except OSError as error:
        raise FirmwareError(f"{doing}: {tool} cannot be run: {error.strerror}") from error
    if ran.returncode:
        said = ran.stdout.strip() or "nothing"
        first = f". {remedy}" if remedy else ""
        raise FirmwareError(f"{doing}: {tool} failed (exit {ran.returncode}){first}. It said:\n{said}")
    return ran.stdout
