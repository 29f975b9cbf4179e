"""The legacy remote API (``simx…``) over the double's scene, on true TCP sockets.

`LegacyServer` in `server` is the front: one port a service. `codec` has the bytes and the command numbers,
`conversation` decides when an answer is sent, `client` holds the state of one client, `object_answers` and
`other_answers` answer commands, `functions` calls the scene, and `faults` lets a server fail.

Not served: split modes, big-endian clients, shared memory, scripts' functions, files, consoles, dialogs and UIs.
"""
