"""``robotcore`` whose guardian may be slow to start: python -m tests.system.guest.patient ARGUMENT...

The product's limits are for a Pi. On an emulated processor a guardian takes longer to start and to open its cutoffs.
"""

from __future__ import annotations

from robotcore.cli.main import main
from robotcore.safety.guardian import guardian, serving
from tests.system.speed import scaled

MAIN = "; main()"

if __name__ == "__main__":
    guardian.STARTING_S = scaled(guardian.STARTING_S)
    limit = f"from robotcore.safety.guardian import serving; serving.OPENING_S = {scaled(serving.OPENING_S)}"
    assert guardian._CODE.endswith(MAIN)
    guardian._CODE = f"{guardian._CODE.removesuffix(MAIN)}; {limit}{MAIN}"
    main()
