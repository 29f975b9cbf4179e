"""The guardian: a separate process that stops the motors if the app's process dies or hangs."""
