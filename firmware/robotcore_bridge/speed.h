// Speed control of a wheel in integers. A speed is the number of counts in a control period of 1/30 s, at most 1000.
// A duty is -255 to 255.
#pragma once
#include <stdint.h>

// In each control period, (kp error - kd change + sum of ki error) / ko is added to the duty. ROSArduinoBridge has the
// same formula, so its gains apply. Because the duty is a sum, kp acts as an integral gain, and kd as a proportional
// gain on the measured speed. So a new target causes no jump.
struct Gains {
  int16_t kp, kd, ki, ko;
};

// The behaviour of a wheel without control: the duty at which it starts to turn, and its speed at full duty.
struct Wheel {
  int16_t startDuty, fullSpeed;
};

class SpeedControl {
public:
  SpeedControl(Wheel wheel, const Gains &gains) : wheel(wheel), gains(gains) {}

  // Sets the target speed for the next steps. The correction is kept, unless the direction changes.
  void setTarget(int16_t speed) {
    const int8_t wanted = static_cast<int8_t>((speed > 0) - (speed < 0));
    if (wanted != direction) correction = sum = 0;
    direction = wanted;
    target = direction < 0 ? -speed : speed;
  }

  // Returns the duty for the next control period from the counts of the last one. The duty never has the opposite sign
  // of the target, and is 0 for the target 0.
  int16_t step(int32_t counts) {
    const int16_t moved = static_cast<int16_t>(limited(counts, -1000, 1000));
    const int16_t change = moved - before;
    before = moved;
    return direction == 0 ? 0 : direction * correctedDuty(target - direction * moved, direction * change);
  }

private:
  static const int32_t ONE = 256, FULL = 255 * ONE; // duties in fixed point

  static int32_t limited(int32_t value, int32_t low, int32_t high) {
    return value < low ? low : value > high ? high : value;
  }

  // Limits the correction and the sum, so that they do not wind up while the duty is at its limit.
  int16_t correctedDuty(int16_t error, int16_t change) {
    const int32_t guess = feedForward();
    const int32_t step = int32_t(gains.kp) * error - int32_t(gains.kd) * change + sum;
    const int32_t wanted = guess + correction + step * ONE / gains.ko;
    const int32_t duty = limited(wanted, 0, FULL);
    const bool isBeyond = wanted < duty ? error < 0 : wanted > duty && error > 0;
    if (!isBeyond) sum = limited(sum + int32_t(gains.ki) * error, -255L * gains.ko, 255L * gains.ko);
    correction = duty - guess;
    return static_cast<int16_t>((duty + ONE / 2) / ONE);
  }

  int32_t feedForward() const {
    const int32_t duty = (wheel.startDuty + int32_t(target) * (255 - wheel.startDuty) / wheel.fullSpeed) * ONE;
    return limited(duty, 0, FULL);
  }

  const Wheel wheel;
  const Gains &gains;
  int8_t direction = 0;
  int16_t target = 0, before = 0;
  int32_t correction = 0, sum = 0;
};
