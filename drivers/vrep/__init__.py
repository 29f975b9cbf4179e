"""The V-REP backend, which uses the legacy remote API over TCP, in pure Python."""
