"""The keys that the reference lists for ``--json`` are those that the commands print.

Those of ``deploy`` and of ``doctor --loopback`` are compared beside the other tests of these commands.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.generator.json_tables import LIST_COMMANDS, SOURCES, VARIANT, has_json
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.cli.json_keys import COMMANDS, find_documented_keys, list_disagreements

LOGGING = """
from robotcore import Behaviour, Role, Status

class Odd(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        robot.log("count", 1.0, "m")
        robot.drive.set_velocity(0.1, 0.0)
        return Status.RUNNING
"""
SIMULATED = ("--backend", "virtualpi", "--robot", "rover")


@pytest.fixture(autouse=True)
def _enter_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def recording(cli: Cli) -> str:
    """Record a short run of an app that logs a value."""
    Path("odd.py").write_text(LOGGING)
    assert cli("run", "odd.py", "--world", "open", "--timeout", "0.5", "--record", "run.mcap").status == 1
    return "run.mcap"


def test_each_command_with_json_has_a_table() -> None:
    assert {words.partition(VARIANT)[0] for words in SOURCES} == {each for each in COMMANDS if has_json(COMMANDS[each])}


@pytest.mark.parametrize("words", SOURCES)
def test_each_key_has_a_value_and_a_meaning(words: str) -> None:
    keys = find_documented_keys(words)
    assert keys
    assert [key for key, each in keys.items() if not each.value or not each.meaning] == []


@pytest.mark.parametrize("words", [*sorted(LIST_COMMANDS), "wiring"])
def test_keys_of_a_list_are_those_of_the_page(words: str, cli: Cli) -> None:
    assert list_disagreements(words, cli(words, "--json").json) == []


def test_keys_of_doctor_are_those_of_the_page(cli: Cli) -> None:
    assert list_disagreements("doctor", cli("doctor", "--backend", "kinematic", "--json").json) == []


def test_keys_of_a_run_are_those_of_the_page(cli: Cli) -> None:
    run = cli("run", "avoid-obstacles", "--timeout", "0.2", "--json").json
    assert list_disagreements("run", run) == []
    assert list_disagreements("run", run, cli("run", "green-serch", "--json").json) == []


@pytest.mark.slow
def test_keys_of_teleop_are_those_of_the_page(cli: Cli) -> None:
    assert (
        list_disagreements("teleop", cli("teleop", "--view", "--timeout", "0.1", "--world", "open", "--json").json)
        == []
    )


@pytest.mark.slow
def test_keys_of_a_sweep_are_those_of_the_page(cli: Cli) -> None:
    assert (
        list_disagreements("sweep", cli("sweep", "avoid-obstacles", "--seeds", "1", "--timeout", "0.2", "--json").json)
        == []
    )


def test_keys_of_info_are_those_of_the_page(cli: Cli, recording: str) -> None:
    assert list_disagreements("info", cli("info", recording, "--json").json) == []


def test_keys_of_a_replay_are_those_of_the_page(cli: Cli, recording: str) -> None:
    equal = cli("replay", recording, "--json").json
    Path("odd.py").write_text(LOGGING.replace("0.1", "0.05"))
    assert list_disagreements("replay", equal, cli("replay", recording, "--app", "odd.py", "--json").json) == []


def test_keys_of_a_replay_of_another_app_are_those_of_the_page(cli: Cli, recording: str) -> None:
    Path("other.py").write_text(LOGGING.replace("Odd", "Other").replace("0.1", "0.05"))
    assert (
        list_disagreements(
            "replay with another app or with `--set`", cli("replay", recording, "--app", "other.py", "--json").json
        )
        == []
    )


def test_keys_of_compare_are_those_of_the_page(cli: Cli, recording: str, brief_recording: Path) -> None:
    assert list_disagreements("compare", cli("compare", recording, str(brief_recording), "--json").json) == []


def test_keys_of_fidelity_are_those_of_the_page(cli: Cli) -> None:
    cli("run", "green-search", "--timeout", "1", "--record", "run.mcap")
    assert list_disagreements("fidelity", cli("fidelity", "run.mcap", "--json").json) == []


def test_keys_of_test_devices_are_those_of_the_page(cli: Cli) -> None:
    assert (
        list_disagreements("test-devices", cli("test-devices", *SIMULATED, "--only", "left_motor", "--json").json) == []
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "words, options",
    [
        ("calibrate motors", ()),
        ("calibrate drive", ("--turns", "1", "--turns-by", "tape")),
        ("calibrate camera", ()),
        ("calibrate range", ("--seconds", "0.5")),
    ],
)
def test_keys_of_a_calibration_are_those_of_the_page(words: str, options: tuple[str, ...], cli: Cli) -> None:
    answer = cli(*words.split(), *SIMULATED, *options, "--json").json
    assert list_disagreements(words, answer) == []
