// An HC-SR04. Interrupts measure the duration of its echo, so that the loop never waits for an echo.
#pragma once
#include <stdint.h>

namespace sonar {

struct Range {
  int16_t mm;   // -1 if the newest measurement had no echo
  uint16_t age; // the age of the newest measurement in ms, at most 65535, which is also the first value
};

void begin();

// Handles a change of a pin. The interrupt calls it.
void edge();

// Triggers a measurement in each cycle, and takes a finished echo. Call this as often as possible.
void poll();

Range newest();

} // namespace sonar
