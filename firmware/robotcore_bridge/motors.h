// Two motors on an L298N.
#pragma once
#include <stdint.h>

enum Side : uint8_t { LEFT, RIGHT };
const Side SIDES[] = {LEFT, RIGHT};

namespace motors {

// Takes the pins, and stands.
void begin();

// Both stand.
void stop();

// Turns one at a duty of -255 to 255; ahead is positive.
void turn(Side side, int16_t duty);

} // namespace motors
