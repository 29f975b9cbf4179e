"""A backend whose simulator runs in another process, behind a socket without time-outs."""
