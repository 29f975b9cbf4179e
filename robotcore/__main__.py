"""``python -m robotcore`` is the command ``robotcore``."""

from robotcore.cli.main import main

if __name__ == "__main__":
    main()
