// Drives the wheels at a controlled speed or at a duty, and stops them after the deadman's time-out.
#pragma once
#include "speed.h"

namespace drive {

const int16_t MAX_SPEED = 1000; // counts in a control period of 1/30 s
const int16_t MAX_DUTY = 255;

// Sets up the motors and the encoders, and stops the motors. Call this first.
void begin();

// Checks the deadman, and controls the speeds once in a control period. Call this as often as possible.
void poll();

// Set the speeds or the duties of both wheels until the next command or the deadman's time-out. The values must not
// exceed MAX_SPEED or MAX_DUTY.
void atSpeed(int16_t left, int16_t right);
void atDuty(int16_t left, int16_t right);

void setDeadman(uint16_t ms);
void setGains(const Gains &gains);

} // namespace drive
