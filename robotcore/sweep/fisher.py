"""Fisher's exact test: the chance that failing runs gather on one side of a split as they do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def log_tails(runs: int, failing: int, sizes: Ints) -> Floats:
    """Return a table: the logarithm of the chance that ``column`` or more of all who fail are inside a split.

    Of shape (sizes, failing + 1), a row for each number of runs inside. Fisher's exact test, one-sided: R. A. Fisher,
    Statistical Methods for Research Workers, 5th ed. (1934), section 21.02. It is the upper tail of the hypergeometric
    distribution; in logarithms, since of a big sweep it may be less than any float.
    """
    inside, size = np.arange(failing + 1), sizes[:, None]
    log_factorial = np.concatenate([[0.0], np.log(np.arange(1, runs + 1)).cumsum()])

    def log_choose(n: int, k: Ints) -> Floats:
        within = np.clip(k, 0, n)
        ways: Floats = log_factorial[n] - log_factorial[within] - log_factorial[n - within]
        return np.where(within == k, ways, -np.inf)

    log_chance = log_choose(failing, inside) + log_choose(runs - failing, size - inside) - log_choose(runs, size)
    return np.logaddexp.accumulate(log_chance[:, ::-1], axis=1)[:, ::-1]
