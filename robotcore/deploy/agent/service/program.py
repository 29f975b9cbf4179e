"""This package as one file, which systemd starts: made of the sources that came with the desk's call."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.system import durable

_MAIN = "from robotcore.deploy.agent.service.main import main\n\nraise SystemExit(main())\n"
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The first moment a ZIP file can tell of: the same sources make the same file."""


def install(layout: Layout, sources: Mapping[str, str]) -> None:
    """Put the program where it is not there like this; ``sources`` are texts by their path, ``robotcore/deploy/…``."""
    content = packed(sources)
    if not layout.program.is_file() or layout.program.read_bytes() != content:
        durable.write(layout.program, content)


def packed(sources: Mapping[str, str]) -> bytes:
    """Return sources as a file that Python runs."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        for path, text in sorted({**sources, "__main__.py": _MAIN}.items()):
            file.writestr(zipfile.ZipInfo(path, _EPOCH), text)
    return content.getvalue()
