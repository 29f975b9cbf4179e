// A time-out for the motors: they stop if no command arrives in time.
#pragma once
#include <stdint.h>

class Deadman {
public:
  explicit Deadman(uint16_t ms) : limit(ms) {}

  void setLimit(uint16_t ms) { limit = ms; }

  // Restarts the time-out after a command that turns a wheel; times are millis(), which wrap.
  void feed(uint32_t now) {
    fed = now;
    armed = true;
  }

  // Switches the time-out off until the next feed, because the motors stand.
  void disarm() { armed = false; }

  // Returns whether the motors must stop, because the last feed is older than the limit.
  bool hasExpired(uint32_t now) const { return armed && now - fed >= limit; }

private:
  uint16_t limit;
  uint32_t fed = 0;
  bool armed = false;
};
