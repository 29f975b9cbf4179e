// The settings for the wiring of your robot. This is the only file to edit. docs/firmware.md describes the wiring.
// Pins have their Arduino names. Every pin except 0 and 1 (the USB line) can be an input.
#pragma once

#define BAUD 57600

// An L298N without its two ENA/ENB jumpers. The enable pins must be 9 and 10, because their timer is not the one of
// millis(). "Left" is the left side of the robot, seen in its driving direction.
#define LEFT_ENABLE_PIN 9     // ENA
#define LEFT_FORWARD_PIN 5    // IN1
#define LEFT_BACKWARD_PIN 6   // IN2
#define RIGHT_ENABLE_PIN 10   // ENB
#define RIGHT_FORWARD_PIN 11  // IN3
#define RIGHT_BACKWARD_PIN 12 // IN4
#define LEFT_MOTOR_REVERSED false // true if `o 100 0` turns the left wheel backward
#define RIGHT_MOTOR_REVERSED false

// Quadrature encoders: every edge of A and B is one count.
#define LEFT_ENCODER_A_PIN 2
#define LEFT_ENCODER_B_PIN 3
#define RIGHT_ENCODER_A_PIN A4
#define RIGHT_ENCODER_B_PIN A5
#define LEFT_ENCODER_REVERSED false // true if `e` counts down while the left wheel turns forward
#define RIGHT_ENCODER_REVERSED false

// An HC-SR04. If none is wired, leave the pins as they are.
#define SONAR_TRIGGER_PIN 7
#define SONAR_ECHO_PIN 8
#define SONAR_MAX_MM 4000 // a longer distance is reported as no echo

// A battery with a voltage divider. The full scale is the battery's voltage at which the pin has 5 V. It is 25 V for
// 30 kohm and 7.5 kohm. Measure it, and correct the number.
#define BATTERY_PIN NOT_WIRED // such as A0
#define BATTERY_FULL_SCALE_MV 25000

// The motors stop after this time without `m` or `o`. The command `k` sets another time until the next reset.
#define DEADMAN_MS 2000

// The feed-forward duty follows from these two values of a wheel without load. The encoder corrects the rest.
// docs/firmware.md describes how to measure both.
#define START_DUTY 20  // of 255. Below this duty, no wheel starts to turn
#define FULL_SPEED 176 // counts in a control period of 1/30 s at duty 255: 960 counts a turn at 330 turns a minute

// The gains of the speed control, as in ROSArduinoBridge's command `u`: 0 to 1000 each, KO at least 1.
#define KP 30
#define KD 40
#define KI 0
#define KO 50
