"""The legacy remote API (``simx…``) over the double's scene, on TCP sockets.

`LegacyServer` in `server` serves ports. `codec` has the bytes and the command numbers. `client` orders the commands and
replies of one client, and `commands` executes the commands. `faults` lets a server fail. The double has the commands
that the driver and the recorded sessions use.
"""
