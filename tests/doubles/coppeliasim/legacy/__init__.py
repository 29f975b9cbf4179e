"""The legacy remote API (``simx…``) over the double's scene, on true TCP sockets.

`LegacyServer` is the front. From the line inwards: `service` and `temporary` (a port each), `codec` (bytes), `codes`,
`conversation` and `inbox` (what is answered when), `client` (who asks), the answers (`objects`, `pictures`, `values`,
`running`, `refused`), `functions` (what the scene does for them), `faults` (how it fails).

Not served: split modes, big-endian clients, shared memory, scripts' functions, files, consoles, dialogs and UIs.
"""
