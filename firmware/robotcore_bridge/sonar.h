// An HC-SR04, measured beside everything else: its echo is timed by interrupts.
#pragma once
#include <stdint.h>

namespace sonar {

struct Range {
  int16_t mm;   // -1 where the newest cycle heard no echo
  uint16_t age; // of it, in ms, at most 65535: a sensor that answers no trigger has no cycles, and its range grows old
};

void begin();

// The echo pin may have changed: called by the interrupt.
void edge();

// Triggers when it is time, and takes an echo that has come: called as often as can be.
void poll();

Range newest();

} // namespace sonar
