// Counts the edges of an encoder's two square waves, which are a quarter of a period apart.
#pragma once
#include <stdint.h>

class Quadrature {
public:
  // Sets the present levels. The count does not change.
  void begin(bool a, bool b) { state = levels(a, b); }

  // Counts a change of the levels, upwards if A is ahead of B. If both levels have changed, an edge in an unknown
  // direction was missed, and nothing is counted.
  void update(bool a, bool b) {
    static const int8_t STEPS[16] = {0, -1, +1, 0, +1, 0, 0, -1, -1, 0, 0, +1, 0, +1, -1, 0};
    const uint8_t now = levels(a, b);
    total += static_cast<uint32_t>(static_cast<int32_t>(STEPS[state << 2 | now]));
    state = now;
  }

  // Returns the count. It wraps at 32 bits, so that differences of two counts are right.
  uint32_t count() const { return total; }

private:
  static uint8_t levels(bool a, bool b) { return static_cast<uint8_t>(a << 1 | b); }

  uint8_t state = 0;
  uint32_t total = 0;
};
