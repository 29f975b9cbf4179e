"""Run the commands of a Markdown page on the files of the page."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from tests.docs.listings import ConsoleCommand, Listing


def write_files(listings: Iterable[Listing], folder: Path) -> None:
    """Write the Python files of a page into a folder."""
    for listing in listings:
        if listing.language == "python":
            (folder / listing.file).write_text(listing.text, encoding="utf-8")


def run_command(command: ConsoleCommand, capfd: pytest.CaptureFixture[str]) -> str:
    """Run a command in the current folder, and return its output. Only ``robotcore`` runs in this process."""
    program, *arguments = shlex.split(command.command)
    if program == "robotcore":
        execute(arguments)
    else:
        module = [] if program == "python" else ["-m", program]
        subprocess.run([sys.executable, *module, *arguments], check=False)
    return "".join(capfd.readouterr())
