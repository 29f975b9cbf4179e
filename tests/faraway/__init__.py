"""A backend as a third party might write it. Its simulator is another process, behind a socket without time-outs."""
