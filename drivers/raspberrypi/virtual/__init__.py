"""A Raspberry Pi that is not there: the same device drivers on virtual pins, with a simulator behind them."""
