from cautious import Cautious
from robotcore import Status
from robotcore.testing import MockRobot


def test_drives_until_the_sensor_reads_the_commanded_speed() -> None:
    robot = MockRobot("robot.toml", readings={"flow": [0.0, 0.1, 0.2]})
    assert robot.run(Cautious(), ticks=3) is Status.SUCCESS
