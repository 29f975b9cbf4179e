// The wheels' quadrature encoders, counted by interrupts at every edge.
#pragma once
#include "motors.h"

namespace encoders {

void begin();

// A pin has changed: called by the interrupt.
void edge();

// Counts since the last reset; ahead is positive.
int32_t count(Side side);

// Counts since the last call for this side, whatever was reset meanwhile.
int32_t moved(Side side);

void reset();

} // namespace encoders
