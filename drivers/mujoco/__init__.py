"""The MuJoCo backend: simulates robots with MuJoCo's rigid-body physics, in this process."""
