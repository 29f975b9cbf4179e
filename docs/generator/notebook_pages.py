"""The notebooks as pages of the site. Each cell runs, and its outputs and pictures are on the page."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import sys
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
INTERRUPTED = "interrupt"
"""The id of the cell that the reader interrupts."""
INTERRUPT_S = 1.0
CELL_LIMIT_S = 60
COLOUR = re.compile(r"\x1b\[[0-9;]*m")
MAX_LINES = 30
"""The greatest number of lines of an output on a page."""


def list_notebook_pages() -> Iterator[tuple[str, str | bytes]]:
    """Run each notebook. Yield the name of its page and its Markdown, and the names and contents of its pictures."""
    for file in sorted(FOLDER.glob("*.ipynb")):
        try:
            cells = _run_in_new_folder(file.stem)
        except CellExecutionError:  # the watchdog may end a run on a busy machine
            cells = _run_in_new_folder(file.stem)
        pictures = _find_pictures(file.stem, cells)
        yield from pictures.items()
        download = f"[Download this notebook]({file.name}), and run it: [the guide](../interactive.md#notebooks)."
        title, *rest = [_format_cell(file.stem, cell) for cell in cells]
        heading, _, intro = title.partition("\n")
        yield f"{file.stem}.md", "\n\n".join([heading, download, intro.strip(), *rest]) + "\n"


def _run_in_new_folder(name: str) -> Any:
    with TemporaryDirectory() as folder:
        for helper in FOLDER.glob("*.py"):
            shutil.copy(helper, folder)
        return run_notebook(name, Path(folder)).cells


def read_notebook(name: str) -> Any:
    """Return the notebook with this name."""
    read: Any = nbformat.read  # without types
    return read(FOLDER / f"{name}.ipynb", as_version=4)


def run_notebook(name: str, folder: Path) -> Any:
    """Run all cells of a notebook in a new kernel, and return the notebook with its outputs.

    The kernel gets an interrupt in the cell `INTERRUPTED`. An error in a cell without the tag ``raises-exception`` is
    raised.

    folder: the kernel's current folder.
    """
    interrupts: list[asyncio.Task[None]] = []

    async def interrupt() -> None:
        await asyncio.sleep(INTERRUPT_S)
        await kernel.interrupt_kernel()

    def on_cell_execute(cell: Any, **_: Any) -> None:
        if cell.id == INTERRUPTED:
            interrupts.append(asyncio.get_running_loop().create_task(interrupt()))

    notebook = read_notebook(name)
    kernel = AsyncKernelManager()
    place = {"metadata": {"path": str(folder)}}
    client = NotebookClient(notebook, kernel, timeout=CELL_LIMIT_S, resources=place, on_cell_execute=on_cell_execute)
    client.extra_arguments = ["--IPKernelApp.log_level=40"]  # errors only
    commands = {**os.environ, "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    client.execute(cleanup_kc=True, env=commands)
    assert all(task.done() for task in interrupts)
    return notebook


def _find_pictures(name: str, cells: Any) -> dict[str, str | bytes]:
    outputs = [(cell.id, output) for cell in cells for output in cell.get("outputs", [])]
    return {
        f"{name}-{cell}.png": b64decode(output.data["image/png"])
        for cell, output in outputs
        if "image/png" in output.get("data", {})
    }


def _format_cell(name: str, cell: Any) -> str:
    if cell.cell_type == "markdown":
        return str(cell.source)
    parts = [f"```python\n{cell.source}\n```"]
    for output in cell.outputs:
        if "image/png" in output.get("data", {}):
            parts.append(f"![The output of the cell {cell.id}]({name}-{cell.id}.png)")
        elif text := COLOUR.sub("", _read_text(output)).rstrip():
            lines = text.splitlines()
            lines = lines if len(lines) <= MAX_LINES else [*lines[:MAX_LINES], "…"]
            parts.append("````text\n{}\n````".format("\n".join(lines)))
    return "\n\n".join(parts)


def _read_text(output: Any) -> str:
    if "ename" in output:
        return f"{output.ename}: {output.evalue}"
    return str(output.get("text") or output.get("data", {}).get("text/plain", ""))
