// The motors' right to turn, which ends by itself.
#pragma once
#include <stdint.h>

class Deadman {
public:
  explicit Deadman(uint16_t ms) : limit(ms) {}

  void setLimit(uint16_t ms) { limit = ms; }

  // A command that turns a wheel has come; times are millis(), which wrap.
  void feed(uint32_t now) {
    fed = now;
    armed = true;
  }

  // The motors were stopped: there is nothing to watch until it is fed again.
  void disarm() { armed = false; }

  // Whether the motors must be stopped now, because nobody has fed it for the limit.
  bool hasExpired(uint32_t now) const { return armed && now - fed >= limit; }

private:
  uint16_t limit;
  uint32_t fed = 0;
  bool armed = false;
};
