"""The PyBullet backend: simulates robots with Bullet's rigid-body physics, in this process."""
