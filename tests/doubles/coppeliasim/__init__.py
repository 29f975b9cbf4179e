"""A double of a CoppeliaSim server: a scene, and servers of both remote APIs on sockets.

- `scene`: the simulated world without a protocol. All servers share one `scene.Simulator`.
- `zmq`: the server of the ZeroMQ remote API, and the ``sim`` functions that the driver calls.
- `legacy`: the server of the legacy remote API, and faults to inject into it.
- `scenes`: the default scene, a robot and a world from descriptions, bubbleRob, the camera relay, and the initial
  scenes of the recordings.
- `recorded`: sessions of a real server, and its table of functions and constants. `replay` compares them with a double.
- `__main__`: the double as a process.

The double has no window and no physics. A robot with two driven wheels moves exactly. No other object moves by itself.
"""
