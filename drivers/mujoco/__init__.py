"""The MuJoCo backend: rigid-body physics through MuJoCo, in this process."""
