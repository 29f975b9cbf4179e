"""A double of a CoppeliaSim server: a scene, and the protocols that true clients speak to it over true sockets.

What is where:

- `scene`: the simulated world without any protocol. `scene.Simulator` is the front: it holds the graph of objects,
  the simulation's state and time, who steps it, and the kinematic world behind it. Every protocol server shares one.
- `zmq`: the ZeroMQ remote API over a simulator (`zmq.ZmqServer`), and the ``sim`` functions by name (`zmq.functions`).
- `legacy`: the legacy remote API over the same simulator.
- `scenes`: scenes in code: the default scene, a described robot in a drawn world, bubbleRob, the camera relay, and
  those that the recordings begin with.
- `recorded`: sessions of a real server, and the table of its functions and constants.
- `replaying`: plays a recorded session to a double and tells where the replies differ (also a small tool).
- `__main__`: the double as a process.

What a protocol server relies on (``with simulator.lock:`` around every use; the lock may be taken again):

    simulator.graph.find("/rover/leftMotor")     an object by path, or None; find_flat("v0") by old name
    simulator.graph[17]                          an object by handle, NoObjectError where there is none
    simulator.graph.pose(thing)                  where it is in the world, as a scene.poses.Transform
    simulator.start() pause() stop()             requests, as the API's
    simulator.state time time_step               what the simulation tells: scene.State, seconds, seconds
    simulator.hold(client) let_go(client)        who steps; a client is any hashable; leave(client) when it is gone
    simulator.step(client)                       lets time go on by a step where nobody else holds it; returns a ticket
    simulator.is_done(ticket)                    whether that step has been made, or there is none to be made any more
    simulator.changed                            a Condition on the lock, notified after every step and change of state
    simulator.picture(sensor)                    what it saw: uint8 (height, width, 3), RGB, row 0 at the bottom
    simulator.show(sensor, pixels)               gives a vision sensor a picture
    simulator.handle(sensor)                     renders one that is handled explicitly, of this instant
    simulator.depth(sensor)                      float32 (height, width), metres along its axis, row 0 at the bottom
    simulator.detection(sensor)                  what a proximity sensor detects, or None
    simulator.contacts()                         who touches whom since the last step

Without a window, and without physics: a robot with two driven wheels moves exactly; nothing else moves by itself.
"""
