// The wheels as they are driven: at a speed that the encoders keep, or at a duty; and what stops them.
#pragma once
#include "speed.h"

namespace drive {

const int16_t MAX_SPEED = 1000; // counts a frame (1/30 s)
const int16_t MAX_DUTY = 255;

// The motors stand: before anything else.
void begin();

// Stops what nobody has fed, and keeps speeds: called as often as can be.
void poll();

// Both wheels turn so until they are told anew, or the deadman ends it. Not beyond the maxima.
void atSpeed(int16_t left, int16_t right);
void atDuty(int16_t left, int16_t right);

void setDeadman(uint16_t ms);
void setGains(const Gains &gains);

} // namespace drive
