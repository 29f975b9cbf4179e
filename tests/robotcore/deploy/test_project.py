from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.deploy.project import DeployOptions, DeployTable, build_project
from robotcore.deploy.push import UNTIL_STOPPED_S, create_release
from robotcore.deploy.requirements import find_extras
from robotcore.errors import DescriptionError, UnknownNameError, UsageError
from tests.robotcore.deploy.projects import DRIVES_ON, TABLE, write, write_project
from tests.texts import Raises


def test_installed_app_needs_no_project_folder(tmp_path: Path) -> None:
    write(tmp_path, {"app.py": DRIVES_ON, "pyproject.toml": "[project]\nname = 'other'\n"})
    project = build_project(DeployOptions(app="green-search", robot="rover"), tmp_path)
    assert project.folder is None
    assert project.name == "green-search"
    assert project.files == ()


def test_named_file_makes_the_current_folder_the_project(tmp_path: Path) -> None:
    write(tmp_path, {"app.py": DRIVES_ON, "pyproject.toml": "[project]\nname = 'mine'\ndependencies = ['click']\n"})
    project = build_project(DeployOptions(app="app.py:Reflex", robot="rover"), tmp_path)
    assert (project.folder, project.name, project.files) == (tmp_path.resolve(), "mine", ("app.py",))
    assert project.metadata.dependencies == ("click",)


def test_options_override_the_table_and_settings_add_up(tmp_path: Path) -> None:
    table = TABLE + 'settings = { speed_m_s = 0.2, is_shy = true }\nrequire = ["contacts<=0"]\n'
    project = write_project(tmp_path, table, settings={"speed_m_s": "0.1"}, rate_hz=50.0, require=(), record=True)
    deploy = project.deploy
    assert deploy.settings == {"speed_m_s": "0.1", "is_shy": "true"}
    assert (deploy.backend, deploy.rate_hz, deploy.require, deploy.record) == ("kinematic", 50.0, (), True)


@pytest.mark.parametrize("value", ["10 bananas", "0min", "NaN"])
def test_a_duration_of_recordings_has_a_unit(tmp_path: Path, value: str, raises: Raises) -> None:
    with raises(DescriptionError, "invalid-value", hide=[tmp_path]):
        write_project(tmp_path, TABLE + f"record_last = '{value}'\n")


def test_a_duration_of_recordings_among_the_options_has_a_unit(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "record-last"):
        write_project(tmp_path, record_last="10")


def test_recordings_keep_ten_minutes_unless_the_project_names_another_duration(tmp_path: Path) -> None:
    assert write_project(tmp_path).deploy.record_last == "10min"
    assert write_project(tmp_path, TABLE + 'record_last = "all"\n').deploy.record_last == "all"
    assert write_project(tmp_path, record_last="2h").deploy.record_last == "2h"


def test_the_live_page_has_a_port_that_needs_no_root(tmp_path: Path, raises: Raises) -> None:
    assert write_project(tmp_path).deploy.view is None
    assert create_release(write_project(tmp_path)).view_port is None
    project = write_project(tmp_path, TABLE + "view = 8080\n")
    release = create_release(project)
    assert (release.view_port, release.run[-2:]) == (8080, ("--view", "8080"))
    assert write_project(tmp_path, TABLE + "view = 9000\n", has_view=True).deploy.view == 9000
    assert write_project(tmp_path, has_view=True).deploy.view == 8080
    assert "view" in find_extras(project)
    assert "view" not in find_extras(write_project(tmp_path))
    with raises(DescriptionError, "out-of-bounds", hide=[tmp_path]):
        write_project(tmp_path, TABLE + "view = 80\n")


def test_files_are_named_from_the_current_folder_and_stored_relative_to_the_project(tmp_path: Path) -> None:
    below = write(tmp_path, {"app.py": DRIVES_ON, "apps/own.py": DRIVES_ON, "pyproject.toml": TABLE}) / "apps"
    assert build_project(DeployOptions(folder=Path(".."), app="own.py"), below).app == "apps/own.py"
    assert build_project(DeployOptions(folder=Path("..")), below).app == "app.py"


@pytest.mark.parametrize("name, kept", [("-x.py", "./-x.py"), ("-x.py:A", "./-x.py:A"), ("a b'$(c).py",) * 2])
def test_path_of_a_file_never_looks_like_an_option(tmp_path: Path, name: str, kept: str) -> None:
    write(tmp_path, {name.partition(":")[0]: DRIVES_ON})
    assert build_project(DeployOptions(app=name, robot="rover"), tmp_path).app == kept


def test_file_outside_of_the_project_is_refused(tmp_path: Path, raises: Raises) -> None:
    write(tmp_path, {"app.py": DRIVES_ON, "inner/pyproject.toml": TABLE})
    with raises(UsageError, "file-outside-project"):
        build_project(DeployOptions(app="../app.py"), tmp_path / "inner")


def test_home_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    write(tmp_path, {"home/app.py": DRIVES_ON, "app.py": DRIVES_ON})
    for folder in (tmp_path / "home", tmp_path):
        with raises(UsageError, "home-folder", hide=[Path.home()]):
            build_project(DeployOptions(app="app.py", robot="rover"), folder)


def test_every_mistake_of_the_table_is_named_by_its_key(tmp_path: Path, raises: Raises) -> None:
    table = '[tool.robotcore]\nap = "a.py"\n[tool.robotcore.deploy]\nsedes = "1"\nsettings = { a = [1] }\n'
    with raises(DescriptionError, "invalid-value") as raised:
        write_project(tmp_path, table)
    mistakes = (raised.value, *raised.value.others)
    prefix = "tool.robotcore"
    assert {each.key for each in mistakes} == {f"{prefix}.ap", f"{prefix}.deploy.sedes", f"{prefix}.deploy.settings.a"}


@pytest.mark.parametrize(
    "options, error, kind",
    [
        (DeployOptions(robot="rover"), UsageError, "missing-option"),
        (DeployOptions(app="green-search"), UsageError, "missing-option"),
        (DeployOptions(app="gren-search", robot="rover"), UnknownNameError, "unknown-app"),
        (DeployOptions(app="green-search", robot="rovr"), UnknownNameError, "unknown-robot"),
        (DeployOptions(app="green-search", robot="rover", backend="raspberypi"), UnknownNameError, "unknown-backend"),
        (DeployOptions(app="green-search", robot="rover", seeds="3-1"), UsageError, ""),
        (DeployOptions(app="green-search", robot="rover", require=("verifed>=1",)), UsageError, ""),
        (DeployOptions(app="green-search", robot="rover", rate_hz=0.0), UsageError, ""),
        (DeployOptions(app="green-search", robot="rover", settings={"sped": "1"}), UnknownNameError, "unknown-setting"),
        (DeployOptions(app="none.py", robot="rover"), UsageError, "no-such-file"),
        (DeployOptions(folder=Path("none")), UsageError, "no-such-folder"),
    ],
)
def test_invalid_options_are_refused(tmp_path: Path, options: DeployOptions, error: type[Exception], kind: str) -> None:
    with pytest.raises(error) as raised:
        build_project(options, tmp_path)
    assert getattr(raised.value, "kind", "").startswith(kind)


def test_unknown_extra_is_reported_with_the_nearest_name(tmp_path: Path, raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-extra", name="tofu"):
        write_project(tmp_path, f'{TABLE}extras = ["tofu"]\n')


def test_release_has_commands_that_run_and_stop_it(tmp_path: Path) -> None:
    project = replace(
        build_project(DeployOptions(app="green-search", robot="rover"), tmp_path),
        deploy=DeployTable(settings={"a": "b c"}),
    )
    release = create_release(project)
    words = ("run", "green-search", "--backend", "raspberrypi", "--timeout", f"{UNTIL_STOPPED_S:.0f}")
    assert release.run == (*words, "--set", "a=b c", "--realtime")
    assert release.stop == ("stop", "--backend", "raspberrypi", "--robot", "rover")


def test_release_for_a_simulator_has_a_world(tmp_path: Path) -> None:
    project = build_project(
        DeployOptions(app="green-search", robot="rover", backend="kinematic", seeds="7-9"), tmp_path
    )
    assert create_release(project).run[2:6] == ("--world", "arena", "--seed", "7")


def test_the_app_has_real_time_priority_if_the_project_or_the_option_says_so(tmp_path: Path) -> None:
    assert "--rt" not in create_release(write_project(tmp_path)).run
    for project in (
        write_project(tmp_path, TABLE + "rt = true\n", backend="raspberrypi"),
        write_project(tmp_path, TABLE, is_real_time=True, backend="raspberrypi"),
    ):
        assert "--rt" in create_release(project).run


def test_a_simulator_in_lockstep_refuses_real_time_priority(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "rt-without-real-time", backend="kinematic"):
        write_project(tmp_path, TABLE + "rt = true\n", backend="kinematic")
