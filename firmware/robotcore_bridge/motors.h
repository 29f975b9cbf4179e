// The two motors on an L298N.
#pragma once
#include <stdint.h>

enum Side : uint8_t { LEFT, RIGHT };
const Side SIDES[] = {LEFT, RIGHT};

namespace motors {

// Sets up the pins, and stops both motors.
void begin();

// Stops both motors.
void stop();

// Turns a motor at a duty of -255 to 255, positive forward.
void turn(Side side, int16_t duty);

} // namespace motors
