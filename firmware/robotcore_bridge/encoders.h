// The quadrature encoders of the wheels; interrupts count every edge.
#pragma once
#include "motors.h"

namespace encoders {

void begin();

// Handles a change of a pin; the interrupt calls it.
void edge();

// Returns the counts since the last reset; forward is positive.
int32_t count(Side side);

// Returns the counts since the last call for this side; resets do not matter.
int32_t moved(Side side);

void reset();

} // namespace encoders
