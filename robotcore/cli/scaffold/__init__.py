"""New projects, made from templates: a robot of one's own, and a package with a backend."""

from robotcore.cli.scaffold.template import DRIVER, PROJECT, Template, make, require_free

__all__ = ["DRIVER", "PROJECT", "Template", "make", "require_free"]
