"""The guardian: a process that outlives the app's, and stops the motors when the app's process cannot."""
