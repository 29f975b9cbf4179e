"""A double of a CoppeliaSim server: a scene, and servers of both remote APIs on sockets.

Contents:

- `scene`: the simulated world without a protocol. `scene.Simulator` has the graph of objects, the simulation's state
  and time, the stepping clients, and the kinematic world. All servers share one simulator.
- `zmq`: the server of the ZeroMQ remote API (`zmq.ZmqServer`), and the ``sim`` functions by name (`zmq.functions`).
- `legacy`: the server of the legacy remote API.
- `scenes`: scenes that are built in code: the default scene, a robot and a world from descriptions, bubbleRob, the
  camera relay, and the initial scenes of the recordings.
- `recorded`: sessions of a real server, and its table of functions and constants.
- `replaying`: replays a recorded session on a double and compares the replies; also a command.
- `__main__`: the double as a process.

The interface for servers (use it inside ``with simulator.lock:``; the lock is reentrant):

    simulator.graph.find("/rover/leftMotor")     an object by path, or None; find_flat("v0") by its old name
    simulator.graph[17]                          an object by handle; raises NoObjectError
    simulator.graph.pose(node)                   its pose in the world, a scene.poses.Transform
    simulator.start() pause() stop()             requests, as the API's
    simulator.state time time_step               scene.State, seconds, seconds
    simulator.hold(client) release(client)       begin and end stepping; a client is any hashable; leave(client)
    simulator.step(client)                       request a step; returns a ticket
    simulator.is_done(ticket)                    whether the step is done, or void
    simulator.changed                            a Condition on the lock, notified after each step and change of state
    simulator.picture(sensor)                    the last picture: uint8 (height, width, 3), RGB, row 0 at the bottom
    simulator.show(sensor, pixels)               show a picture on a vision sensor
    simulator.handle(sensor)                     render a sensor with explicit handling now
    simulator.depth(sensor)                      float32 (height, width), metres along its axis, row 0 at the bottom
    simulator.detection(sensor)                  the detection of a proximity sensor, or None
    simulator.contacts()                         the contacts in the last step

The double has no window and no physics. A robot with two driven wheels moves exactly. No other object moves by itself.
"""
