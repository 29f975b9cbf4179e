"""The built-in backend: exact differential-drive motion, ray-cast ranges, a painted camera."""
