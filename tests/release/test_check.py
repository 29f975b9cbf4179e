"""A release whose tag, version, changelog and corpus agree passes, and each disagreement is a problem."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

if sys.version_info < (3, 11):
    pytest.skip("the check of a release needs Python 3.11", allow_module_level=True)

from release import check
from release.check import find_problems, main, read_section, read_version
from tests.texts import CheckText

CHANGELOG = """# Changelog

## [Unreleased]

## [0.2.0] - 2027-01-31

### Added

- **Wings.** A robot flies. [docs/wings.md](docs/wings.md)

## [0.1.0] - 2026-12-01

The first version.
"""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Return a repository that is ready for the release of 0.2.0."""
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "robotcore"\nversion = "0.2.0"\n')
    (tmp_path / "CHANGELOG.md").write_text(CHANGELOG)
    (tmp_path / "tests" / "compatibility" / "0.2.0").mkdir(parents=True)
    return tmp_path


def change(root: Path, file: str, old: str, new: str) -> None:
    text = (root / file).read_text()
    assert old in text
    (root / file).write_text(text.replace(old, new))


def test_a_release_whose_parts_agree_has_no_problem(root: Path) -> None:
    assert list(find_problems(root, "v0.2.0")) == []


def test_a_candidate_has_the_section_and_the_corpus_of_its_release(root: Path) -> None:
    change(root, "pyproject.toml", "0.2.0", "0.2.0rc1")
    assert list(find_problems(root, "v0.2.0rc1")) == []
    assert read_section(root, "0.2.0rc1") == read_section(root, "0.2.0")


@pytest.mark.parametrize("tag", ["0.2.0", "v0.2", "v0.2.0-beta", "release", ""])
def test_a_tag_of_another_form_is_a_problem(root: Path, tag: str, check_text: CheckText) -> None:
    (problem,) = find_problems(root, tag)
    check_text(problem)


@pytest.mark.parametrize(
    "file, old, new",
    [
        ("pyproject.toml", "0.2.0", "0.2.1"),
        ("CHANGELOG.md", "## [0.2.0] - 2027-01-31\n", ""),
        ("CHANGELOG.md", "- 2027-01-31", "- soon"),
        ("CHANGELOG.md", " - 2027-01-31", ""),
        ("CHANGELOG.md", "[0.1.0]", "[0.2.0]"),
        ("CHANGELOG.md", "## [0.2.0]", "## [0.3.0] - 2027-02-01\n\n## [0.2.0]"),
        ("CHANGELOG.md", "### Added\n\n- **Wings.** A robot flies. [docs/wings.md](docs/wings.md)\n", ""),
        ("CHANGELOG.md", "- **Wings.** A robot flies. [docs/wings.md](docs/wings.md)", "<!-- later -->"),
        ("CHANGELOG.md", "- 2027-01-31", "- 20270131"),
        ("CHANGELOG.md", "## [Unreleased]\n", "## [Unreleased]\n\n- **Arms.** A robot lifts.\n"),
    ],
    ids=[
        "version",
        "no section",
        "wrong date",
        "no date",
        "two sections",
        "not newest",
        "empty",
        "no entry",
        "date of another form",
        "unreleased entries",
    ],
)
def test_each_disagreement_is_a_problem(root: Path, file: str, old: str, new: str, check_text: CheckText) -> None:
    change(root, file, old, new)
    (problem,) = find_problems(root, "v0.2.0")
    check_text(problem)


def test_a_missing_corpus_is_a_problem(root: Path, check_text: CheckText) -> None:
    (root / "tests" / "compatibility" / "0.2.0").rmdir()
    (problem,) = find_problems(root, "v0.2.0")
    check_text(problem)


def test_the_notes_are_the_section_of_the_version(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check, "ROOT", root)
    notes = tmp_path / "notes.md"
    assert main(["v0.2.0", "--notes", str(notes)]) == 0
    assert notes.read_text() == "### Added\n\n- **Wings.** A robot flies. [docs/wings.md](docs/wings.md)\n"
    assert capsys.readouterr().out == "v0.2.0 can be released\n"


def test_a_problem_has_exit_status_1_and_no_notes(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check, "ROOT", root)
    notes = tmp_path / "notes.md"
    assert main(["v0.3.0", "--notes", str(notes)]) == 1
    assert capsys.readouterr().err.startswith("error: the tag is v0.3.0")
    assert not notes.exists()


def test_a_file_that_cannot_be_read_or_written_is_a_problem(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check, "ROOT", root)
    assert main(["v0.2.0", "--notes", str(tmp_path / "missing" / "notes.md")]) == 1
    (root / "CHANGELOG.md").write_bytes(b"\xff")
    assert main(["v0.2.0"]) == 1
    assert capsys.readouterr().err.count("error: a file of the release cannot be read or written") == 2


def test_the_version_of_this_repository_is_read() -> None:
    assert read_version(check.ROOT).count(".") == 2
