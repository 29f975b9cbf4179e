from tests.robotcore.deploy.actions import aboard
from tests.robotcore.deploy.sshd import sshd

__all__ = ["aboard", "sshd"]
