#include "drive.h"

#include <Arduino.h>

#include "config.h"
#include "deadman.h"
#include "encoders.h"
#include "motors.h"

namespace {

const uint32_t FRAME_US = 33333;

Deadman deadman(DEADMAN_MS);
Gains gains = {KP, KD, KI, KO};
SpeedControl controls[] = {{{START_DUTY, FULL_SPEED}, gains}, {{START_DUTY, FULL_SPEED}, gains}};
bool byEncoder = false;

// Returns whether a frame is due. Frames keep their rate; after a pause of two frames the period restarts.
bool isFrameDue() {
  static uint32_t last = 0;
  const uint32_t passed = micros() - last;
  if (passed < FRAME_US) return false;
  last += passed < 2 * FRAME_US ? FRAME_US : passed;
  return true;
}

void controlSpeeds() {
  for (Side side : SIDES) {
    const int16_t duty = controls[side].step(encoders::moved(side));
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
  if (isFrameDue()) controlSpeeds();
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
