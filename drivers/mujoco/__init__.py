"""MuJoCo's rigid-body physics."""
