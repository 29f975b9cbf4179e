"""A sweep as one page: self-contained, to be read over coffee or to grade a class with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

from robotcore.description import WorldDescription
from robotcore.errors import BackendMissingError, UsageError
from robotcore.sweep.durable import part_path, replace_text
from robotcore.sweep.record import Record
from robotcore.sweep.statistics import Requirement

PAGE = "index.html"


def write_report(
    records: Sequence[Record],
    directory: Path,
    folder: Path,
    *,
    command: str = "",
    worlds: Sequence[WorldDescription] = (),
    requirements: Sequence[Requirement] = (),
) -> Path:
    """Write ``directory/index.html`` and return its path.

    ``folder`` is the sweep's, which a record's picture is relative to; ``command`` is the command of the sweep;
    ``worlds`` are those that are not shipped; ``requirements`` are listed with the values that were reached. Raises
    BackendMissingError where Jinja2 is missing and UsageError where the page cannot be written.
    """
    require_writable(directory)
    from robotcore.sweep.report.page import render_page

    html = render_page(records, folder, command, worlds, requirements)
    with _report_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        with replace_text(directory / PAGE, errors="replace") as file:
            file.write(html)
    return directory / PAGE


def require_writable(directory: Path) -> None:
    """Raise, before a long sweep and not after it, where a report could not be written; leave no new folder behind.

    BackendMissingError where Jinja2 is missing, UsageError where the folder cannot be written.
    """
    if find_spec("jinja2") is None:
        raise BackendMissingError(
            "--report needs Jinja2, which is not installed. pip install 'robotcore[sweep]'",
            kind="library-missing",
            module="jinja2",
            extra="sweep",
        )
    made = [folder for folder in (directory, *directory.parents) if not folder.exists()]
    with _report_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
        probe = part_path(directory / PAGE)
        probe.touch()
        probe.unlink()
    with suppress(OSError):  # where somebody else has put something there meanwhile
        for folder in made:
            folder.rmdir()


@contextmanager
def _report_errors(directory: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UsageError(
            f"--report {directory}: {error.strerror}. Name a folder that can be written",
            kind="unusable-folder",
            directory=str(directory),
        ) from error
