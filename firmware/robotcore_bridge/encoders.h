// The quadrature encoders of the wheels. Interrupts count every edge.
#pragma once
#include "motors.h"

namespace encoders {

void begin();

// Handles a change of a pin. The interrupt calls it.
void edge();

// Returns the counts since the last reset, positive forward.
int32_t count(Side side);

// Returns the counts since the last call of this function for this side. A reset does not change them.
int32_t takeCounts(Side side);

void reset();

} // namespace encoders
