"""The public modules of robotcore, by the title of their page in the reference.

The names of a module are public if they are in its ``__all__``. Without ``__all__``, all names are public that the
module defines and that have no underscore at the beginning. `tests/test_public_names.py` requires an example for each.
"""

PUBLIC_MODULES: dict[str, list[str]] = {
    "Apps": [
        "robotcore",
        "robotcore.runtime.behaviour",
        "robotcore.runtime.settings",
        "robotcore.hal.robot",
        "robotcore.hal.drive",
        "robotcore.hal.truth",
    ],
    "Runs": [
        "robotcore.runtime.request",
        "robotcore.runtime.session",
        "robotcore.runtime.result",
        "robotcore.runtime.observer",
        "robotcore.runtime.trace",
        "robotcore.runtime.tick_statistics",
        "robotcore.safety.velocity_limits",
        "robotcore.safety.latch",
        "robotcore.runtime.operator_input",
        "robotcore.runtime.pace",
        "robotcore.runtime.plan",
        "robotcore.cli.main",
    ],
    "A robot at a prompt": [
        "robotcore.interactive.opening",
        "robotcore.interactive.live_robot",
        "robotcore.interactive.live_drive",
    ],
    "Devices": [
        "robotcore.kinds.motor",
        "robotcore.kinds.range_sensor",
        "robotcore.kinds.camera",
        "robotcore.kinds.encoder",
        "robotcore.kinds.battery",
        "robotcore.kinds.bumper",
        "robotcore.kinds.button",
        "robotcore.kinds.buzzer",
        "robotcore.kinds.display",
        "robotcore.kinds.gamepad",
        "robotcore.kinds.imu",
        "robotcore.kinds.led",
        "robotcore.kinds.lidar",
        "robotcore.kinds.line_sensor",
        "robotcore.kinds.operator",
        "robotcore.kinds.servo",
    ],
    "Manoeuvres and routines": [
        "robotcore.autonomy.manoeuvres",
        "robotcore.autonomy.routines",
    ],
    "Navigation": [
        "robotcore.autonomy.navigation",
        "robotcore.autonomy.heading",
    ],
    "Vision": [
        "robotcore.autonomy.vision",
        "robotcore.optics",
    ],
    "Geometry": ["robotcore.geometry"],
    "Errors": ["robotcore.errors"],
    "Tests": ["robotcore.testing", "robotcore.testing.bench"],
    "Faults": ["robotcore.runtime.faults", "robotcore.runtime.layers.base"],
    "Descriptions of robots and worlds": ["robotcore.description"],
    "Recordings": [
        "robotcore.recording",
        "robotcore.recording.recorder",
        "robotcore.recording.replay",
    ],
    "Sweeps and fidelity": [
        "robotcore.sweep",
        "robotcore.sweep.statistics",
        "robotcore.fidelity.fidelity",
    ],
    "Deployment": [
        "robotcore.deploy.host",
        "robotcore.deploy.project",
        "robotcore.deploy.push",
    ],
    "Device drivers": [
        "robotcore.hardware",
        "robotcore.hal.wiring",
        "robotcore.hal.sampling",
        "robotcore.hal.cutoff",
        "robotcore.hal.check_finding",
    ],
    "Backends and kinds of devices": [
        "robotcore.hal.backend",
        "robotcore.hal.device",
        "robotcore.hal.kind",
        "robotcore.hal.simulation_state",
        "robotcore.hal.joint",
        "robotcore.hal.device_test",
        "robotcore.hal.clock",
        "robotcore.hal.wall_clock",
        "robotcore.plugins",
    ],
}
"""A mapping from the title of a page to its modules, in the order of the pages and of the modules on a page."""
