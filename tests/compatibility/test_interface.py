"""The present interface has every part of the interface of each released version."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest

from tests.compatibility.conftest import HERE, VERSIONS
from tests.compatibility.interface import describe_interface

PARTS = ("commands", "classes", "registered", "driver_settings")
LISTS = ("error_kinds", "robot_keys", "world_keys")

pytestmark = pytest.mark.slow  # the interface imports everything

of_all_versions = pytest.mark.parametrize("version", VERSIONS)


@cache
def read_interface(version: str) -> Any:
    return json.loads((HERE / version / "interface.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def present() -> dict[str, Any]:
    return describe_interface()


@of_all_versions
@pytest.mark.parametrize("part", PARTS)
def test_each_name_still_has_what_it_had(version: str, part: str, present: dict[str, Any]) -> None:
    now = present[part]
    missing = {name: set(each) - set(now.get(name, ())) for name, each in read_interface(version)[part].items()}
    assert {name: each for name, each in missing.items() if each or name not in now} == {}


@of_all_versions
@pytest.mark.parametrize("part", LISTS)
def test_each_key_and_each_kind_of_error_still_exists(version: str, part: str, present: dict[str, Any]) -> None:
    assert set(read_interface(version)[part]) - set(present[part]) == set()


@of_all_versions
def test_each_error_has_its_kind_and_its_exit_status(version: str, present: dict[str, Any]) -> None:
    before = read_interface(version)["errors"]
    assert {name: present["errors"].get(name) for name in before} == before


@of_all_versions
def test_each_call_from_python_is_still_valid(version: str, present: dict[str, Any]) -> None:
    for name, parameters in read_interface(version)["names"].items():
        assert name in present["names"]
        now, before = present["names"][name], {each.rstrip("!") for each in parameters}
        assert before <= {each.rstrip("!") for each in now}, name
        assert {each for each in now if each.endswith("!")} <= {f"{each}!" for each in before}, name
        required = [each for each in now if each.endswith("!")]
        assert [each for each in parameters if each in required] == required, name
