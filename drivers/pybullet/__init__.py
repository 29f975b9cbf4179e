"""The Bullet backend: rigid-body physics through PyBullet, in process."""
