#include "motors.h"

#include <Arduino.h>

#include "config.h"

namespace {

struct Motor {
  uint8_t enable, forward, backward;
};

const Motor MOTORS[] = {
    LEFT_MOTOR_REVERSED ? Motor{LEFT_ENABLE_PIN, LEFT_BACKWARD_PIN, LEFT_FORWARD_PIN}
                        : Motor{LEFT_ENABLE_PIN, LEFT_FORWARD_PIN, LEFT_BACKWARD_PIN},
    RIGHT_MOTOR_REVERSED ? Motor{RIGHT_ENABLE_PIN, RIGHT_BACKWARD_PIN, RIGHT_FORWARD_PIN}
                         : Motor{RIGHT_ENABLE_PIN, RIGHT_FORWARD_PIN, RIGHT_BACKWARD_PIN},
};

} // namespace

void motors::begin() {
  for (const Motor &motor : MOTORS) {
    digitalWrite(motor.enable, LOW); // before it becomes an output
    pinMode(motor.enable, OUTPUT);
    pinMode(motor.forward, OUTPUT);
    pinMode(motor.backward, OUTPUT);
  }
  stop();
}

void motors::stop() {
  turn(LEFT, 0);
  turn(RIGHT, 0);
}

// Changes the direction only while the bridge is off, so that no glitch turns the wheel.
void motors::turn(Side side, int16_t duty) {
  const Motor &motor = MOTORS[side];
  const bool reverses = digitalRead(duty > 0 ? motor.backward : motor.forward) == HIGH;
  if (duty == 0 || reverses) digitalWrite(motor.enable, LOW);
  digitalWrite(motor.forward, duty > 0);
  digitalWrite(motor.backward, duty < 0);
  if (duty != 0) analogWrite(motor.enable, abs(duty));
}
