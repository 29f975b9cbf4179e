"""What whoever connects such a board must know."""

BOARD = (
    "The board runs ROSArduinoBridge, or the firmware that robotcore firmware flash puts on it, which stops sooner, "
    "sums its lines, and measures range and battery beside all else."
)
TIMEOUT = (
    "The true ROSArduinoBridge stops the motors 2 s after the last command, whatever board_timeout_s says; "
    "our firmware takes board_timeout_s."
)
COUNTING = (
    "The board takes whole counts in 1/30 s: set_velocity returns the velocity that they are, and what is less than "
    "half a count stands."
)
PINGING = (
    "The true ROSArduinoBridge does nothing else while it listens for an echo, 38 ms where none comes and 1 s where no "
    "module is at that pin: it holds no velocity and takes no stop until then."
)
