"""Over a real simulator's legacy remote API: ROBOTCORE_VREP=127.0.0.1:19997 python -m tests.system.vrep."""
