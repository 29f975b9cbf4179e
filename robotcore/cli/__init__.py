"""The command line. A command's module is imported only if the command is used."""
