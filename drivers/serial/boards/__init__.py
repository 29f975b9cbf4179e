"""Motor boards. Each board has a folder with its protocol and its device drivers."""
