"""Run a notebook in a kernel, and read the outputs of its cells."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import nbformat
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient

from tests.kernels import CellOutputs

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
INTERRUPTED = "interrupt"
"""The id of the cell that the reader interrupts."""
INTERRUPT_S = 1.0


def read_notebook(name: str) -> Any:
    """Return the notebook with this name."""
    read: Any = nbformat.read  # without types
    return read(FOLDER / f"{name}.ipynb", as_version=4)


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
