"""The kinds of devices. Each module holds one kind; other packages register theirs as entry points.

>>> from robotcore.kinds import Camera
>>> Camera.kind
'camera'
"""

from robotcore.kinds.battery import Battery as Battery
from robotcore.kinds.bumper import Bumper as Bumper
from robotcore.kinds.button import Button as Button
from robotcore.kinds.buzzer import Buzzer as Buzzer
from robotcore.kinds.camera import Camera as Camera
from robotcore.kinds.display import Display as Display
from robotcore.kinds.encoder import Encoder as Encoder
from robotcore.kinds.gamepad import Gamepad as Gamepad
from robotcore.kinds.imu import Imu as Imu
from robotcore.kinds.led import Led as Led
from robotcore.kinds.lidar import Lidar as Lidar
from robotcore.kinds.line_sensor import LineSensor as LineSensor
from robotcore.kinds.motor import Motor as Motor
from robotcore.kinds.operator import Operator as Operator
from robotcore.kinds.range_sensor import RangeSensor as RangeSensor
from robotcore.kinds.servo import Servo as Servo
