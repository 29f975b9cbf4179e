"""The V-REP backend: the legacy remote API over TCP, in pure Python."""
