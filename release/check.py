"""Check that a tag, the version, the changelog and the compatibility corpus agree, before a release.

    python -m release.check v0.2.0
    python -m release.check v0.2.0 --notes notes.md    # also write the changelog's section of the version

It needs the standard library of Python 3.11 only. The exit status is 1 if something does not agree.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import tomllib

ROOT = Path(__file__).parents[1]
TAG = re.compile(r"v(?P<version>[0-9]{1,5}\.[0-9]{1,5}\.[0-9]{1,5}(?:rc[0-9]{1,5})?)")
HEADING = re.compile(r"^## \[(?P<name>[^\]]+)\](?: - (?P<date>\S+))?[ \t]*$", re.MULTILINE)
ENTRY = re.compile(r"^- \S", re.MULTILINE)
CORPORA = Path("tests", "compatibility")


def main(arguments: list[str] | None = None) -> int:
    """Print each problem of a release, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tag", help="the tag of the release, such as v0.2.0")
    parser.add_argument("--notes", metavar="FILE", type=Path, help="write the changelog's section into this file")
    options = parser.parse_args(arguments)
    try:
        problems = list(find_problems(ROOT, options.tag))
        if options.notes and not problems:
            version = options.tag.removeprefix("v")
            options.notes.write_text(read_section(ROOT, version) + "\n", encoding="utf-8")
    except (OSError, ValueError, KeyError) as error:  # a file that is missing, or no UTF-8, TOML or project
        problems = [f"a file of the release cannot be read or written: {type(error).__name__}: {error}. Correct it"]
    for problem in problems:
        sys.stderr.write(f"error: {problem}\n")
    if problems:
        return 1
    sys.stdout.write(f"{options.tag} can be released\n")
    return 0


def find_problems(root: Path, tag: str) -> Iterator[str]:
    """Yield the reasons why a tag cannot be released, each with a remedy.

    root: the folder of the repository.
    tag: the tag, such as ``v0.2.0``, or ``v0.2.0rc1`` for a release candidate.
    """
    found = TAG.fullmatch(tag)
    if not found:
        yield f"the tag {tag!r} is not of the form vX.Y.Z. Name it after the version, such as v0.2.0"
        return
    version = found["version"]
    if (written := read_version(root)) != version:
        yield f"the tag is {tag}, and the version in pyproject.toml is {written}. Change one of them"
    final = version.partition("rc")[0]
    yield from _find_changelog_problems(root, final)
    if not (root / CORPORA / final).is_dir():
        yield (
            f"{CORPORA / final} does not exist. Make it on this commit: "
            f"python -m tests.compatibility.make_corpus {final}"
        )


def _find_changelog_problems(root: Path, version: str) -> Iterator[str]:
    headings = list(HEADING.finditer(_read_changelog(root)))
    names = [each["name"] for each in headings]
    if version not in names:
        yield f"CHANGELOG.md has no section [{version}]. Rename the section [Unreleased], and add its date"
        return
    if names.count(version) > 1:
        yield f"CHANGELOG.md has {names.count(version)} sections [{version}]. Leave one"
    released = [name for name in names if name != "Unreleased"]
    if released[0] != version:
        yield f"the newest section of CHANGELOG.md is [{released[0]}], not [{version}]. Put the new section first"
    written = headings[names.index(version)]["date"] or ""
    if not _is_date(written):
        yield f"the section [{version}] of CHANGELOG.md has the date {written!r}. Write ## [{version}] - YYYY-MM-DD"
    if not ENTRY.search(read_section(root, version)):
        yield f"the section [{version}] of CHANGELOG.md has no entry. Write what changed for users: - **Name.** Text"
    if "Unreleased" in names and ENTRY.search(read_section(root, "Unreleased")):
        yield f"CHANGELOG.md has entries below [Unreleased]. Move them to [{version}]"


def _is_date(text: str) -> bool:
    try:
        return re.fullmatch(r"[0-9]{4}-[0-9]{2}-[0-9]{2}", text) is not None and bool(date.fromisoformat(text))
    except ValueError:
        return False


def read_version(root: Path) -> str:
    """Return the version in ``pyproject.toml``. No other file has it."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["version"])


def read_section(root: Path, version: str) -> str:
    """Return the text of a version's section of the changelog, without its heading.

    version: the version; the section of a release candidate is that of its release.
    """
    text = _read_changelog(root)
    headings = list(HEADING.finditer(text))
    ends = [*(each.start() for each in headings[1:]), len(text)]
    final = version.partition("rc")[0]
    return next(
        (text[each.end() : end].strip() for each, end in zip(headings, ends, strict=True) if each["name"] == final), ""
    )


def _read_changelog(root: Path) -> str:
    return (root / "CHANGELOG.md").read_text(encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
