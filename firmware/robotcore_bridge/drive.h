// Drives the wheels at a controlled speed or at a duty, and stops them after the deadman's time.
#pragma once
#include "speed.h"

namespace drive {

const int16_t MAX_SPEED = 1000; // counts a frame (1/30 s)
const int16_t MAX_DUTY = 255;

// Stops the motors; call this first.
void begin();

// Checks the deadman and controls the speeds; call this as often as possible.
void poll();

// Sets both wheels until the next command or the deadman's time. The values are within the maxima.
void atSpeed(int16_t left, int16_t right);
void atDuty(int16_t left, int16_t right);

void setDeadman(uint16_t ms);
void setGains(const Gains &gains);

} // namespace drive
