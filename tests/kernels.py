"""A Jupyter kernel in a test."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from jupyter_client.blocking.client import BlockingKernelClient
from jupyter_client.manager import KernelManager

COLOUR = re.compile(r"\x1b\[[0-9;]*m")
LIMIT_S = 60.0


@dataclass(frozen=True)
class CellOutputs:
    """The outputs of a cell, as the kernel sends them."""

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
        return [each["ename"] for each in self.outputs if "ename" in each]

    @property
    def traceback(self) -> list[str]:
        """The lines of the traceback, without colours."""
        text = "\n".join(line for each in self.outputs for line in each.get("traceback", []))
        return COLOUR.sub("", text).splitlines()


class Kernel:
    """A kernel that runs cells.

    client: the client of the kernel, which is ready.
    """

    def __init__(self, client: BlockingKernelClient) -> None:
        self._client = client
        self.group = int(self.run("import os; os.getpgid(0)").text)
        """The number of the kernel's process group."""

    def run(self, code: str, *, interrupt_after: str | None = None) -> CellOutputs:
        """Run a cell, and return its outputs. Interrupt it as soon as it has printed ``interrupt_after``."""
        outputs: list[Any] = []

        def receive(message: dict[str, Any]) -> None:
            outputs.append(message["content"])
            if interrupt_after and interrupt_after in message["content"].get("text", ""):
                os.killpg(self.group, signal.SIGINT)  # as Jupyter does it

        self._client.execute_interactive(code, allow_stdin=False, timeout=LIMIT_S, output_hook=receive)
        return CellOutputs(outputs)

    def complete(self, code: str) -> list[str]:
        """Return the completions of an unfinished cell, as the Tab key shows them."""
        reply = self._client.complete(code, reply=True, timeout=LIMIT_S)
        return list(reply["content"]["matches"])


@pytest.fixture
def kernel_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder for a kernel, which finds the commands of this Python, and no settings of the user."""
    settings = tmp_path / ".jupyter"
    for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(settings))
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    return tmp_path


@pytest.fixture
def kernel(kernel_folder: Path) -> Iterator[Kernel]:
    """Start a kernel. After the test, shut it down, and check that none of its processes runs on."""
    manager = KernelManager()
    manager.start_kernel(cwd=str(kernel_folder))
    client = manager.client()
    try:
        client.start_channels()
        client.wait_for_ready(timeout=LIMIT_S)
        kernel = Kernel(client)
        assert kernel.group != os.getpgid(0)
        yield kernel
    finally:
        client.stop_channels()
        manager.shutdown_kernel()
    with pytest.raises(ProcessLookupError):
        os.killpg(kernel.group, 0)
