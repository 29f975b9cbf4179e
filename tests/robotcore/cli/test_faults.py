from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import RunRequest
from robotcore.description import load_robot
from robotcore.runtime.faults import plan_faults
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

SHORT = ("avoid-obstacles", "--world", "open", "--set", "duration_s=0.5")
ROVER = load_robot("rover")


def test_a_run_shows_its_faults_in_canonical_form(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "faults.toml"
    file.write_text('[[fault]]\ntarget = "left_motor"\neffect = "weak"\nvalue = 0.60\n')
    asked = ("--fault", str(file), "--fault", "range  no-echo=0.10  after=60")
    assert cli("run", *SHORT, *asked, "--json").json["faults"] == ["left_motor weak=0.6", "range no_echo=0.1 after=60"]
    answer = cli("run", *SHORT, *asked).out
    check_text("\n".join(line for line in answer.splitlines() if "=0." in line))


@pytest.mark.slow
@pytest.mark.parametrize("spec", ["range dorp=1", "gone.toml"])
def test_a_wrong_fault_is_refused_before_anything_runs(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spec: str, check_text: CheckText
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = cli("sweep", *SHORT, "--fault", spec, "--json")
    assert (answer.status, answer.json["exit_status"]) == (2, 2)
    check_text(answer.err)
    assert list(tmp_path.iterdir()) == []
    failed = cli("run", *SHORT, "--fault", "range  drop=0.50", "--robot", "nobody", "--json")
    assert (failed.status, failed.json["faults"]) == (2, ["range drop=0.5"])


@pytest.mark.slow
def test_a_sweep_has_its_faults_in_every_run_its_command_and_its_table(
    cli: Cli, requests: list[RunRequest], tmp_path: Path
) -> None:
    arguments = ("sweep", *SHORT, "--seeds", "1-2", "--out", str(tmp_path / "out"))
    assert cli(*arguments, "--fault", "left_motor weak=0.6", "--fault", "loop stall=0.2").status == 0
    assert [request.faults for request in requests] == 2 * [("left_motor weak=0.6", "loop stall=0.2")]
    record = (tmp_path / "out" / "results.jsonl").read_text().splitlines()[0]
    assert "--fault 'left_motor weak=0.6' --fault 'loop stall=0.2'" in record
    assert "left_motor weak=0.6; loop stall=0.2" in (tmp_path / "out" / "results.csv").read_text()
    other = cli(*arguments)
    assert other.status == 2


def test_every_example_in_the_list_is_a_fault(cli: Cli) -> None:
    examples = [fault["example"] for fault in cli("faults", "--json").json]
    planned = plan_faults(examples, ROVER, [device.name for device in ROVER.devices])
    assert [str(fault.spec) for fault in planned] == examples


def test_a_fault_is_listed_with_its_targets_units_and_limits(cli: Cli, check_text: CheckText) -> None:
    noises = [fault for fault in cli("faults", "--json").json if fault["name"] == "noise"]
    targets = {fault["parameters"][0]["unit"]: fault["on"] for fault in noises}
    assert (targets["grey levels"], targets["metres"]) == (["camera"], ["range"])
    assert {"battery", "encoders"} <= set(targets["number"])
    assert {"bumper", "camera", "range"}.isdisjoint(targets["number"])
    table = cli("faults").out
    assert "grey levels" in table
    check_text(table.rpartition("\n\n")[2])
