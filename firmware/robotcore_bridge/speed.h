// Keeping a wheel at its speed, in integers. Speeds are counts a frame (1/30 s), at most 1000; duties -255 to 255.
#pragma once
#include <stdint.h>

// Each step adds (kp error - kd change + sum of ki error) / ko to the duty, as ROSArduinoBridge does, so that its
// gains fit. As the duty is a sum of such steps, kp is what others call integral gain, and kd proportional gain, on the
// measured speed alone: a new target gives no kick.
struct Gains {
  int16_t kp, kd, ki, ko;
};

// How a wheel turns by itself: it starts at a duty, and has a speed at full duty.
struct Wheel {
  int16_t startDuty, fullSpeed;
};

class SpeedControl {
public:
  SpeedControl(Wheel wheel, const Gains &gains) : wheel(wheel), gains(gains) {}

  // From the next step on. What friction and load were found to take stays, but when the direction changes.
  void setTarget(int16_t speed) {
    const int8_t asked = static_cast<int8_t>((speed > 0) - (speed < 0));
    if (asked != direction) correction = sum = 0;
    direction = asked;
    target = direction < 0 ? -speed : speed;
  }

  // Returns the duty for the next frame, given the counts of the last one. It never pushes against the direction that was
  // asked for, and none is asked for at 0.
  int16_t step(int32_t counts) {
    const int16_t moved = static_cast<int16_t>(limited(counts, -1000, 1000));
    const int16_t change = moved - before;
    before = moved;
    return direction == 0 ? 0 : direction * corrected(target - direction * moved, direction * change);
  }

private:
  static const int32_t ONE = 256, FULL = 255 * ONE; // duties in fixed point

  static int32_t limited(int32_t value, int32_t low, int32_t high) {
    return value < low ? low : value > high ? high : value;
  }

  // What cannot be had is not added up: the correction ends where the duty does, and there its sum only comes back.
  int16_t corrected(int16_t error, int16_t change) {
    const int32_t guess = guessed();
    const int32_t step = int32_t(gains.kp) * error - int32_t(gains.kd) * change + sum;
    const int32_t wanted = guess + correction + step * ONE / gains.ko;
    const int32_t duty = limited(wanted, 0, FULL);
    const bool isBeyond = wanted < duty ? error < 0 : wanted > duty && error > 0;
    if (!isBeyond) sum = limited(sum + int32_t(gains.ki) * error, -255L * gains.ko, 255L * gains.ko);
    correction = duty - guess;
    return static_cast<int16_t>((duty + ONE / 2) / ONE);
  }

  int32_t guessed() const {
    const int32_t duty = (wheel.startDuty + int32_t(target) * (255 - wheel.startDuty) / wheel.fullSpeed) * ONE;
    return limited(duty, 0, FULL);
  }

  const Wheel wheel;
  const Gains &gains;
  int8_t direction = 0;
  int16_t target = 0, before = 0;
  int32_t correction = 0, sum = 0;
};
