"""Motor boards: a folder for each, with its frames (protocol), what is said to it and heard (board), its drivers."""
