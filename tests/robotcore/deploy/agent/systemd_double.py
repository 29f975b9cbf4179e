"""Doubles of systemctl and journalctl that print recorded output, see `systemd_states`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from robotcore.deploy.agent import health_check, journal
from robotcore.deploy.agent.systemd_units import SERVICE
from tests.robotcore.deploy.agent.systemd_states import NEVER_WAS, format_properties

_SYSTEMCTL = """#!/bin/sh
cd "$(dirname "$0")"
shift 2
echo "$*" >> calls
if [ -f "fault.$1" ]; then cat "fault.$1" >&2; exit 1; fi
for unit; do :; done
case "$1" in
is-system-running) cat system; [ "$(cat system)" = running ];;
show)
  seen=$(($(cat "seen.$unit") + 1))
  [ -f "look.$unit.$seen" ] || seen=$((seen - 1))
  echo $seen > "seen.$unit"
  if [ -f "then.$unit.$seen" ]; then sh "./then.$unit.$seen"; fi
  cat "look.$unit.$seen";;
esac
"""

_JOURNALCTL = """#!/bin/sh
cd "$(dirname "$0")"
echo "$*" >> asked
case "$*" in *MESSAGE_ID=*) cat ended; exit;; esac
[ ! -f unreadable ] || { cat unreadable >&2; exit 1; }
cat journal
"""


@dataclass(frozen=True)
class ScriptedSystemd:
    """Sets the output of the doubles in a folder, and reads the commands that they received."""

    folder: Path

    def set_states(self, *looks: str, unit: str = SERVICE) -> None:
        """Set the answers to successive queries of a unit's state. The last answer repeats."""
        for old in self.folder.glob(f"look.{unit}.*"):
            old.unlink()
        for number, look in enumerate(looks, 1):
            self.folder.joinpath(f"look.{unit}.{number}").write_text(format_properties(look))
        self.folder.joinpath(f"seen.{unit}").write_text("0")

    def run_at(self, look: int, command: str, unit: str = SERVICE) -> None:
        """Set a shell command that runs at the query of a unit's state with the number ``look``, from 1 on."""
        self.folder.joinpath(f"then.{unit}.{look}").write_text(command)

    def fail(self, verb: str, words: str) -> None:
        """Make a command of systemctl fail with this message."""
        self.folder.joinpath(f"fault.{verb}").write_text(words + "\n")

    def set_lines(self, *lines: str) -> None:
        """Set the app's lines in the journal."""
        self.folder.joinpath("journal").write_text("".join(f"{line}\n" for line in lines))

    def set_last_end(self, text: str) -> None:
        """Set systemd's journal entry about the last end of the app, in JSON."""
        self.folder.joinpath("ended").write_text(text)

    @property
    def calls(self) -> list[str]:
        """The commands that systemd received, in order, without queries."""
        lines = self.folder.joinpath("calls").read_text().splitlines()
        return [line for line in lines if not line.startswith(("show", "is-", "reset-failed"))]

    @property
    def journal_arguments(self) -> str:
        """The arguments that journalctl received."""
        return self.folder.joinpath("asked").read_text()


@pytest.fixture
def systemd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ScriptedSystemd:
    """A systemd in which neither unit was ever started. The agent polls it without a pause."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, source in (("systemctl", _SYSTEMCTL), ("journalctl", _JOURNALCTL)):
        folder.joinpath(name).write_text(source)
        folder.joinpath(name).chmod(0o755)
    scripted = ScriptedSystemd(folder)
    scripted.set_lines()
    scripted.set_last_end("")
    folder.joinpath("calls").touch()
    folder.joinpath("system").write_text("running\n")
    for unit in (SERVICE, "robotcore-health-check.service"):
        scripted.set_states(NEVER_WAS, unit=unit)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "runtime"))
    for module, name in ((health_check, "POLL_S"), (health_check, "FOLLOW_POLL_S"), (journal, "_RETRY_S")):
        monkeypatch.setattr(module, name, 0.0)
    return scripted
