#include "encoders.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"
#include "pins.h"
#include "quadrature.h"

namespace {

Quadrature wheels[2];
uint32_t zeros[2], taken[2];

bool leftA() { return isHigh(LEFT_ENCODER_REVERSED ? LEFT_ENCODER_B_PIN : LEFT_ENCODER_A_PIN); }
bool leftB() { return isHigh(LEFT_ENCODER_REVERSED ? LEFT_ENCODER_A_PIN : LEFT_ENCODER_B_PIN); }
bool rightA() { return isHigh(RIGHT_ENCODER_REVERSED ? RIGHT_ENCODER_B_PIN : RIGHT_ENCODER_A_PIN); }
bool rightB() { return isHigh(RIGHT_ENCODER_REVERSED ? RIGHT_ENCODER_A_PIN : RIGHT_ENCODER_B_PIN); }

uint32_t total(Side side) {
  uint32_t count = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { count = wheels[side].count(); }
  return count;
}

} // namespace

void encoders::begin() {
  watch(LEFT_ENCODER_A_PIN);
  watch(LEFT_ENCODER_B_PIN);
  watch(RIGHT_ENCODER_A_PIN);
  watch(RIGHT_ENCODER_B_PIN);
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    wheels[LEFT].begin(leftA(), leftB());
    wheels[RIGHT].begin(rightA(), rightB());
  }
}

void encoders::edge() {
  wheels[LEFT].update(leftA(), leftB());
  wheels[RIGHT].update(rightA(), rightB());
}

int32_t encoders::count(Side side) { return static_cast<int32_t>(total(side) - zeros[side]); }

int32_t encoders::takeCounts(Side side) {
  const uint32_t before = taken[side];
  taken[side] = total(side);
  return static_cast<int32_t>(taken[side] - before);
}

void encoders::reset() {
  for (Side side : SIDES) zeros[side] = total(side);
}
