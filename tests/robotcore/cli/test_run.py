from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import cv2
import pytest

from robotcore import RunRequest
from robotcore.cli.run import command
from tests.robotcore.cli.conftest import AppFile, Cli
from tests.texts import CheckText

KEYS = {
    *("app", "backend", "robot", "world", "seed", "outcome", "exit_status", "reason", "verified", "sim_time_s"),
    *(
        "wall_time_s",
        "ticks",
        "overruns",
        "tick_times_us",
        "contacts",
        "distance_to_target_m",
        "interventions",
        "intervention_s",
    ),
    *("milestones", "judge", "conditions", "faults", "notes", "batteries", "dropped_pictures", "trace_sha256", "ideal"),
}
SHORT = ("run", "avoid-obstacles", "--world", "open", "--set", "duration_s=0.5")


def test_json_is_one_line_with_every_key(cli: Cli) -> None:
    answer = cli(*SHORT, "--seed", "4", "--json")
    assert answer.status == 0
    assert set(answer.json) == KEYS
    assert (answer.json["outcome"], answer.json["world"], answer.json["seed"]) == ("success", "open", 4)
    assert answer.err == ""


def test_randomise_has_the_drawn_conditions_in_json_and_repeats(cli: Cli) -> None:
    one, again = (cli(*SHORT, "--seed", "4", "--randomise", "--json").json for _ in range(2))
    assert one["conditions"]["floor_pattern"]
    assert one["conditions"] == again["conditions"]
    assert one["trace_sha256"] == again["trace_sha256"]


def test_without_json_the_outcome_comes_first(cli: Cli) -> None:
    answer = cli(*SHORT)
    assert answer.out.startswith("success  avoid-obstacles on kinematic, open\n")
    assert answer.err == ""


def test_a_run_without_the_robot_of_the_project_names_its_options(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pyproject.toml").write_text('[tool.robotcore]\nrobot = "my robot.toml"\nworld = "room.toml"\n')
    line = "The robot was rover. To run the robot of pyproject.toml, add: --robot 'my robot.toml'"
    without_world = tuple(word for word in SHORT if word not in ("--world", "open"))
    assert cli(*without_world).out.endswith(f"{line} --world room.toml\n")
    assert cli(*SHORT).out.endswith(f"{line}\n")
    assert line not in cli(*SHORT, "--robot", "rover").out


def test_a_success_that_the_simulator_does_not_confirm_is_a_failure(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    judge = tmp_path / "judge.py"
    app = Path(app_file("return Status.SUCCESS"))
    judge.write_text(app.read_text() + "\n    def verify(self, truth):\n        return False\n")
    answer = cli("run", str(judge))
    assert (answer.status, answer.err) == (1, "")
    assert answer.out.startswith("disputed  ")
    verdicts = [answer.out.splitlines()[1], cli("run", str(app), "--judge", str(judge)).out.splitlines()[1]]
    check_text("\n".join(each.partition(",")[0] for each in verdicts))
    result = cli("run", str(app), "--judge", str(judge), "--json").json
    assert [result[key] for key in ("outcome", "verified", "judge", "exit_status")] == ["success", False, str(judge), 1]


def test_timeout_is_a_failure(cli: Cli) -> None:
    answer = cli("run", "green-search", "--world", "open", "--timeout", "0.2", "--json")
    assert (answer.status, answer.json["outcome"], answer.json["ticks"]) == (1, "timeout", 5)


def test_output_of_a_subprocess_is_not_in_the_json(cli: Cli, app_file: AppFile) -> None:
    answer = cli("run", app_file("os.system('echo raw')"), "--timeout", "0.3", "--json")
    assert answer.json["ticks"] == 7
    assert answer.err == "raw\n"


def test_an_app_that_raises_shows_its_own_part_of_the_traceback(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    answer = cli("run", app_file("1 / 0"), "--json")
    assert (answer.status, answer.json["kind"], answer.json["ticks"]) == (5, "behaviour", 3)
    assert answer.json["error"] == answer.json["reason"]
    check_text(answer.plain_err)
    assert [line for line in answer.err.splitlines() if "File " in line] == [
        f'    File "{tmp_path}/odd.py", line 13, in step'
    ]


def test_an_app_that_exits_when_it_is_imported_is_reported(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    app = tmp_path / "script.py"
    app.write_text("exit()")
    answer = cli("run", str(app))
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


def test_an_app_that_exits_in_its_constructor_has_raised(cli: Cli, app_file: AppFile, check_text: CheckText) -> None:
    app = Path(app_file("pass"))
    app.write_text(app.read_text() + "\n    def __init__(self):\n        exit(0)\n")
    answer = cli("run", str(app))
    assert (answer.status, answer.out) == (5, "")
    check_text(answer.plain_err)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_run_with_its_line(cli: Cli, app_file: AppFile, number: signal.Signals) -> None:
    answer = cli("run", app_file(f"os.kill(os.getpid(), {int(number)})"), "--json")
    assert answer.status == 128 + number
    assert (answer.json["outcome"], answer.json["kind"], answer.json["ticks"]) == ("interrupted", "interrupted", 3)
    assert number.name in answer.json["reason"]
    assert answer.err == ""


def test_a_signal_before_the_run_has_its_line_too(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.runtime.session.run", lambda *_, **__: signal.raise_signal(signal.SIGTERM))
    answer = cli(*SHORT, "--json")
    assert answer.status == 143
    assert (answer.json["outcome"], answer.json["app"]) == ("interrupted", "avoid-obstacles")


def test_host_and_port_are_options_of_the_backend(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    requests = _collect_requests(monkeypatch)
    cli("run", "a", "--host", "pi.local", "--port", "23000", "--option", "port=1", "--option", "path=/a=b")
    assert requests[0].options == {"host": "pi.local", "port": "23000", "path": "/a=b"}


def test_defaults_are_those_of_a_request(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    requests = _collect_requests(monkeypatch)
    cli("run", "a")
    assert requests == [RunRequest("a")]


def test_every_field_of_a_request_has_an_option() -> None:
    names = {parameter.name for parameter in command.params}
    assert set(RunRequest.__dataclass_fields__) - {"has_operator", "has_separate_motors"} <= names
    assert "keys" in names  # which adds the operator


def test_picture_is_a_png_of_the_run_and_does_not_change_it(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.png"
    assert cli(*SHORT, "--picture", str(file)).out.endswith(f"\nThe picture: {file}\n")
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (1000, 1600, 3)
    answer = cli(*SHORT, "--picture", str(file), "--json")
    assert answer.json["trace_sha256"] == cli(*SHORT, "--json").json["trace_sha256"]
    check_text(answer.err)


@pytest.mark.parametrize("name", ["missing/run.png", "run.jpg", "folder.png"])
def test_picture_that_cannot_be_written_is_refused_before_the_run(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    requests = _collect_requests(monkeypatch)
    (tmp_path / "folder.png").mkdir()
    answer = cli(*SHORT, "--json", "--picture", str(tmp_path / name))
    assert (answer.status, requests) == (2, [])
    assert name in answer.json["reason"]


def test_a_run_that_did_not_begin_writes_no_picture(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "run.png"
    assert cli("run", "green-serch", "--picture", str(file)).out == ""
    assert not file.exists()
    file.write_bytes(b"precious")
    cli("run", "green-serch", "--picture", str(file))
    assert file.read_bytes() == b"precious"


def _collect_requests(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return a list to which each later request is added. No request is run."""
    requests: list[Any] = []

    def collect(request: RunRequest, *_: object, **__: object) -> None:
        requests.append(request)
        raise KeyboardInterrupt

    monkeypatch.setattr("robotcore.runtime.session.run", collect)
    return requests


def test_profile_names_the_phases_the_devices_and_the_lines_of_the_app(cli: Cli, app_file: AppFile) -> None:
    answer = cli("run", app_file("__import__('time').sleep(0.2); return Status.SUCCESS"), "--profile")
    assert all(name in answer.out for name in ("decide", "left_motor", "odd.py:13", "sleep(0.2)"))


def test_the_profile_of_a_run_that_ends_in_its_first_tick_has_no_table_of_phases(cli: Cli, tmp_path: Path) -> None:
    app = tmp_path / "short.py"
    app.write_text(
        "from robotcore import Behaviour, Status\n\nclass Short(Behaviour):\n"
        "    def step(self, robot):\n        return Status.SUCCESS\n"
    )
    answer = cli("run", str(app), "--profile")
    assert answer.out.startswith("success")
    assert "phase of a tick" not in answer.out


def test_the_profile_of_a_run_with_json_is_on_stderr(cli: Cli) -> None:
    answer = cli(*SHORT, "--profile", "--json")
    assert answer.json["outcome"] == "success"
    assert "phase of a tick" in answer.err
