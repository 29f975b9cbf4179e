"""Run a notebook in a kernel, and read the outputs of its cells."""

from __future__ import annotations

import asyncio
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
INTERRUPTED = "interrupt"
"""The id of the cell that the reader interrupts."""
INTERRUPT_S = 1.0
COLOUR = re.compile(r"\x1b\[[0-9;]*m")


@dataclass(frozen=True)
class CellOutputs:
    """The outputs of a cell."""

    outputs: list[Any]

    @property
    def text(self) -> str:
        """The printed text, and the text of the result, without colours."""
        texts = (each.get("text") or each.get("data", {}).get("text/plain", "") for each in self.outputs)
        return COLOUR.sub("", "".join(texts))

    @property
    def number(self) -> float:
        """The first decimal number of the text."""
        found = re.search(r"-?\d+\.\d+", self.text)
        assert found, self.text
        return float(found[0])

    @property
    def has_picture(self) -> bool:
        """Whether the cell shows a picture."""
        return any("image/png" in each.get("data", {}) for each in self.outputs)

    @property
    def errors(self) -> list[str]:
        """The names of the errors that ended the cell."""
        return [each["ename"] for each in self.outputs if each["output_type"] == "error"]


def read_notebook(name: str) -> Any:
    """Return the notebook with this name."""
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)  # type: ignore[no-untyped-call]


def run_notebook(name: str, folder: Path) -> dict[str, CellOutputs]:
    """Run all cells of a notebook in a new kernel, and return the outputs of each code cell by its id.

    The kernel gets an interrupt in the cell `INTERRUPTED`. An error in a cell without the tag ``raises-exception`` is
    raised.

    folder: the kernel's current folder.
    """
    interrupts: list[asyncio.Task[None]] = []

    async def interrupt() -> None:
        await asyncio.sleep(INTERRUPT_S)
        await kernel.interrupt_kernel()

    def on_cell_execute(cell: Any, cell_index: int) -> None:
        if cell.id == INTERRUPTED:
            interrupts.append(asyncio.get_running_loop().create_task(interrupt()))

    notebook, kernel = read_notebook(name), AsyncKernelManager()
    place = {"metadata": {"path": str(folder)}}
    client = NotebookClient(notebook, kernel, timeout=60, resources=place, on_cell_execute=on_cell_execute)
    client.execute(cleanup_kc=True)
    assert all(task.done() for task in interrupts)
    return {cell.id: CellOutputs(cell.outputs) for cell in notebook.cells if cell.cell_type == "code"}
