"""Write the report of a sweep: one self-contained web page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from robotcore.description import WorldDescription
from robotcore.errors import UsageError
from robotcore.extras import require_extra
from robotcore.files import replace_text, require_replaceable
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
    """Write the report ``directory/index.html``, and return its path.

    records: the records of the sweep.
    directory: the folder of the report. It is created if it does not exist.
    folder: the folder of the sweep's results. The picture files of the records are relative to it.
    command: the command line of the sweep, which the page shows.
    worlds: the descriptions of the user's own worlds.
    requirements: the requirements. The page shows the value that each group of runs reached.

    Raises BackendMissingError if Jinja2 is missing, and UsageError if the page cannot be written.
    """
    require_writable(directory)
    from robotcore.sweep.report.page import render_page

    html = render_page(records, folder, command, worlds, requirements)
    with _make_folder(directory), replace_text(directory / PAGE, errors="replace") as file:
        file.write(html)
    return directory / PAGE


def require_writable(directory: Path) -> None:
    """Check, before a long sweep, that `write_report` can write to a folder. The check creates no folder.

    Raises BackendMissingError if Jinja2 is missing, and UsageError if the folder cannot be written.
    """
    require_extra("sweep", "--report")
    with _make_folder(directory):
        require_replaceable(directory / PAGE)


@contextmanager
def _make_folder(directory: Path) -> Iterator[None]:
    """Create the folder of a report, and report errors. A folder that is still empty at the end is deleted again."""
    made = [folder for folder in (directory, *directory.parents) if not folder.exists()]
    try:
        directory.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise UsageError(
            f"--report {directory}: {error.strerror}. Name a writable folder",
            kind="unusable-folder",
            directory=str(directory),
        ) from error
    finally:
        with suppress(OSError):  # the folder has a file
            for folder in made:
                folder.rmdir()
