// The time-out after which the motors stop without a new command.
#pragma once
#include <stdint.h>

class Deadman {
public:
  explicit Deadman(uint16_t ms) : limit(ms) {}

  void setLimit(uint16_t ms) { limit = ms; }

  // Restarts the time-out after a command that turns a wheel. All times are values of millis(), which wrap.
  void feed(uint32_t now) {
    fed = now;
    armed = true;
  }

  // Switches the time-out off until the next call of feed. The motors are stopped.
  void disarm() { armed = false; }

  // Returns whether the last call of feed is older than the limit, so that the motors must stop.
  bool hasExpired(uint32_t now) const { return armed && now - fed >= limit; }

private:
  uint16_t limit;
  uint32_t fed = 0;
  bool armed = false;
};
