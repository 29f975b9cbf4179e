"""New projects, made from templates: a robot of one's own, and a package with a backend."""

from robotcore.scaffold.making import make
from robotcore.scaffold.naming import require_free
from robotcore.scaffold.template import DRIVER, PROJECT, Template

__all__ = ["DRIVER", "PROJECT", "Template", "make", "require_free"]
