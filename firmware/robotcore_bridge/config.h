// All that depends on how your robot is wired: the only file to edit.
// Pins have their Arduino names; every pin but 0 and 1 (the USB line) may serve as input. docs/firmware.md has the wiring.
#pragma once

#define BAUD 57600

// L298N, its two ENA/ENB jumpers taken off. The enable pins must be 9 and 10: they share a timer, which leaves
// millis() alone. "Left" is the robot's own left, as it looks ahead.
#define LEFT_ENABLE_PIN 9     // ENA
#define LEFT_FORWARD_PIN 5    // IN1
#define LEFT_BACKWARD_PIN 6   // IN2
#define RIGHT_ENABLE_PIN 10   // ENB
#define RIGHT_FORWARD_PIN 11  // IN3
#define RIGHT_BACKWARD_PIN 12 // IN4
#define LEFT_MOTOR_REVERSED false // true where `o 100 0` turns the left wheel backward
#define RIGHT_MOTOR_REVERSED false

// Quadrature encoders: every edge of A and B is one count.
#define LEFT_ENCODER_A_PIN 2
#define LEFT_ENCODER_B_PIN 3
#define RIGHT_ENCODER_A_PIN A4
#define RIGHT_ENCODER_B_PIN A5
#define LEFT_ENCODER_REVERSED false // true where `e` counts down while the left wheel turns forward
#define RIGHT_ENCODER_REVERSED false

// HC-SR04. Where none is wired the pins may stay as they are.
#define SONAR_TRIGGER_PIN 7
#define SONAR_ECHO_PIN 8
#define SONAR_MAX_MM 4000 // an echo from farther is none

// Battery, by a divider: the voltage at which the pin has 5 V. 30 kohm above 7.5 kohm: 25 V. Measure, and correct it.
#define BATTERY_PIN NOT_WIRED // such as A0
#define BATTERY_FULL_SCALE_MV 25000

// What stops it by itself: no `m` or `o` for so long. The command `k` sets another until the next reset.
#define DEADMAN_MS 2000

// What a wheel does unloaded, for a good first guess at the duty; its encoder corrects the rest. docs/firmware.md
// says how to measure them.
#define START_DUTY 20  // of 255: below it no wheel begins to turn
#define FULL_SPEED 176 // counts in 1/30 s at duty 255: 960 counts a turn at 330 turns a minute

// How the encoder corrects: the gains of the command `u`, as ROSArduinoBridge has them; 0 to 1000 each, KO at least 1.
#define KP 30
#define KD 40
#define KI 0
#define KO 50
