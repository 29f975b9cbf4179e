"""The legacy remote API (``simx…``) over the double's scene, on TCP sockets.

`LegacyServer` in `server` serves ports. `codec` has the bytes and the command numbers. `conversation` orders commands
and replies. `client` holds the state of one client. `object_commands` and `other_commands` answer commands. `functions`
calls the scene. `faults` lets a server fail.

Not supported: split modes, big-endian clients, shared memory, scripts' functions, files, consoles, dialogs and UIs.
"""
