"""Serial ports: where one is, the one thread that reads and writes it, and what becomes of it when it is lost."""
