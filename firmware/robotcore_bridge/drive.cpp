#include "drive.h"

#include <Arduino.h>

#include "config.h"
#include "deadman.h"
#include "encoders.h"
#include "motors.h"

namespace {

const uint32_t CONTROL_PERIOD_US = 33333;

Deadman deadman(DEADMAN_MS);
Gains gains = {KP, KD, KI, KO};
SpeedControl controls[] = {{{START_DUTY, FULL_SPEED}, gains}, {{START_DUTY, FULL_SPEED}, gains}};
bool byEncoder = false;

// Returns whether a control period has passed. A late call does not shift the next periods, unless it is late by a
// whole period.
bool isControlDue() {
  static uint32_t last = 0;
  const uint32_t passed = micros() - last;
  if (passed < CONTROL_PERIOD_US) return false;
  last += passed < 2 * CONTROL_PERIOD_US ? CONTROL_PERIOD_US : passed;
  return true;
}

void controlSpeeds() {
  for (Side side : SIDES) {
    const int16_t duty = controls[side].step(encoders::takeCounts(side));
    if (byEncoder) motors::turn(side, duty);
  }
}

void setTargets(int16_t left, int16_t right) {
  controls[LEFT].setTarget(left);
  controls[RIGHT].setTarget(right);
}

void stop() {
  motors::stop();
  deadman.disarm();
  byEncoder = false;
  setTargets(0, 0);
}

} // namespace

void drive::begin() {
  motors::begin();
  encoders::begin();
}

void drive::poll() {
  if (deadman.hasExpired(millis())) stop();
  if (isControlDue()) controlSpeeds();
}

void drive::atSpeed(int16_t left, int16_t right) {
  if (left == 0 && right == 0) return stop();
  deadman.feed(millis());
  byEncoder = true;
  setTargets(left, right);
}

void drive::atDuty(int16_t left, int16_t right) {
  if (left == 0 && right == 0) return stop();
  deadman.feed(millis());
  byEncoder = false;
  setTargets(0, 0);
  motors::turn(LEFT, left);
  motors::turn(RIGHT, right);
}

void drive::setDeadman(uint16_t ms) { deadman.setLimit(ms); }

void drive::setGains(const Gains &wanted) { gains = wanted; }
