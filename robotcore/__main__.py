"""``python -m robotcore`` is the command ``robotcore``."""

import sys

try:
    from robotcore.cli.main import main
except ModuleNotFoundError as error:
    if (error.name or "robotcore").partition(".")[0] == "robotcore":
        raise
    sys.stderr.write(
        f"error: {error.name} is not installed for {sys.executable}. Install robotcore's packages: "
        "python -m pip install -e . in a clone\n"
    )
    sys.exit(2)

if __name__ == "__main__":
    main()
