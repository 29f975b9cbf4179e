"""``robotcore`` with longer time limits for the guardian: python -m tests.system.guest.scaled_limits ARGUMENT...

robotcore's limits are for a Pi. On an emulated processor a guardian takes longer to start and to open its cutoffs.
"""

from __future__ import annotations

from robotcore.cli.main import main
from robotcore.safety.guardian import client, process
from tests.system.speed import scaled

MAIN = "; main()"


def scale_limits() -> None:
    """Scale the guardian's time limits, also in its process."""
    client.START_TIMEOUT_S = scaled(client.START_TIMEOUT_S)
    limit = f"from robotcore.safety.guardian import process; process.OPENING_S = {scaled(process.OPENING_S)}"
    assert client._CODE.endswith(MAIN)
    client._CODE = f"{client._CODE.removesuffix(MAIN)}; {limit}{MAIN}"


if __name__ == "__main__":
    scale_limits()
    main()
