from tests.robotcore.deploy.sshd import sshd

__all__ = ["sshd"]
