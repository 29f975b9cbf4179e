from __future__ import annotations

from collections.abc import Iterator

import pytest

from robotcore import compatibility
from robotcore.compatibility import check_range, check_requirements, format_minimum, is_newer, read_version


@pytest.fixture
def version(monkeypatch: pytest.MonkeyPatch) -> Iterator[pytest.MonkeyPatch]:
    """Let this robotcore be of version 0.4.2."""
    monkeypatch.setattr(compatibility, "version", lambda package: "0.4.2")
    read_version.cache_clear()
    yield monkeypatch
    read_version.cache_clear()


@pytest.mark.parametrize("needed", [">=0.4", ">=0.4.2", ">=0.1,<1", "~=0.4", "==0.4.*", ""])
def test_a_range_with_this_version_is_met(version: pytest.MonkeyPatch, needed: str) -> None:
    assert check_range(needed) is None


@pytest.mark.parametrize("needed", [">=0.5", ">0.4.2", "~=0.5", "==0.5", ">=0.5,<1"])
def test_the_remedy_for_a_range_of_newer_versions_is_an_update(version: pytest.MonkeyPatch, needed: str) -> None:
    unmet = check_range(needed)
    assert unmet
    assert (set(unmet.needed.split(",")), unmet.installed) == (set(needed.split(",")), "0.4.2")
    assert unmet.remedy == "Update robotcore"


@pytest.mark.parametrize("needed", ["<0.4", "<=0.4.1", "~=0.3.0", "!=0.4.2"])
def test_the_remedy_for_other_versions_is_one_in_the_range(version: pytest.MonkeyPatch, needed: str) -> None:
    unmet = check_range(needed)
    assert unmet
    assert unmet.remedy == "Install a version of robotcore in this range"


@pytest.mark.parametrize("installed", ["0.5.0rc1", "0.5.0.dev3", "0.5.0+local"])
def test_a_candidate_of_a_release_is_in_the_range_of_the_release(version: pytest.MonkeyPatch, installed: str) -> None:
    version.setattr(compatibility, "version", lambda package: installed)
    assert check_range(">=0.5") is None


@pytest.mark.parametrize("needed", ["0.2", "newest", ">=x", ">=0.1; python_version>'3'"])
def test_a_text_that_is_no_range_raises_an_error(needed: str) -> None:
    with pytest.raises(ValueError, match="Invalid specifier"):
        check_range(needed)


def test_a_range_with_a_number_of_thousands_of_digits_is_refused_by_its_length() -> None:
    with pytest.raises(ValueError, match="a range of versions has at most 100 characters, and this one has 5002"):
        check_range(">=" + "9" * 5000)


@pytest.mark.parametrize(
    "requirements, needed",
    [
        (["numpy>=1000", "robotcore>=0.5"], ">=0.5"),
        (["Robotcore[sim]>=0.5"], ">=0.5"),
        (["robotcore>=0.1", "robotcore-drivers>=9"], None),
        (["robotcore>=9; extra == 'next'"], None),
        (["robotcore>=0.5; python_version >= '3'"], ">=0.5"),
        (["robotcore"], None),
        (["robotcore>=0.1", "robotcore>=0.5"], ">=0.5"),
        (["robotcore>=0.1", "robotcore[sim]<0.3; python_version >= '3'"], "<0.3"),
        (["robotcore>=0.1", "robotcore>=0.2"], None),
        (["is this one?"], None),
        ([], None),
    ],
)
def test_the_range_of_a_package_is_that_of_its_requirements_of_robotcore(
    version: pytest.MonkeyPatch, requirements: list[str], needed: str | None
) -> None:
    unmet = check_requirements(requirements)
    assert (unmet.needed if unmet else None) == needed


def test_a_newer_version_is_compared_by_number_and_not_by_text(version: pytest.MonkeyPatch) -> None:
    assert is_newer("0.10.0")
    assert not is_newer("0.4.2")
    assert not is_newer("0.4.1")
    assert not is_newer("a version")


def test_the_minimum_is_the_minor_version(version: pytest.MonkeyPatch) -> None:
    assert format_minimum() == ">=0.4"
