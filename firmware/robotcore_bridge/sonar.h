// An HC-SR04; interrupts measure the time of its echo, so nothing waits for it.
#pragma once
#include <stdint.h>

namespace sonar {

struct Range {
  int16_t mm;   // -1 if the newest cycle had no echo
  uint16_t age; // in ms, at most 65535; it grows if the sensor does not answer its trigger
};

void begin();

// Handles a change of a pin; the interrupt calls it.
void edge();

// Triggers a measurement when it is due, and takes a finished echo; call this as often as possible.
void poll();

Range newest();

} // namespace sonar
