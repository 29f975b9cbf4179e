"""A backend as third parties write them: its simulator is a process of its own, behind a socket without time-outs."""
