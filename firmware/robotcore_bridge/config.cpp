// Compile-time checks of config.h, such as that no two functions share a pin.
#include "config.h"

#include <Arduino.h>

#include "pins.h"

namespace {

constexpr int16_t PINS[] = {
    LEFT_ENABLE_PIN,   LEFT_FORWARD_PIN,    LEFT_BACKWARD_PIN,   RIGHT_ENABLE_PIN,    RIGHT_FORWARD_PIN,
    RIGHT_BACKWARD_PIN, LEFT_ENCODER_A_PIN, LEFT_ENCODER_B_PIN,  RIGHT_ENCODER_A_PIN, RIGHT_ENCODER_B_PIN,
    SONAR_TRIGGER_PIN, SONAR_ECHO_PIN,      BATTERY_PIN,
};

constexpr uint8_t uses(int16_t pin, uint8_t from = 0) {
  return from == sizeof(PINS) / sizeof(PINS[0]) ? 0 : (PINS[from] == pin) + uses(pin, from + 1);
}

constexpr bool isWithin(long value, long low, long high) { return low <= value && value <= high; }

} // namespace

#define REQUIRE_PIN(pin)                                                                                               \
  static_assert(isWithin(pin, 2, A5), "config.h: " #pin ": no such pin. The pins are 2 to 13 and A0 to A5");           \
  static_assert(uses(pin) == 1, "config.h: " #pin ": this pin is used twice. Give each function its own pin")

REQUIRE_PIN(LEFT_ENABLE_PIN);
REQUIRE_PIN(LEFT_FORWARD_PIN);
REQUIRE_PIN(LEFT_BACKWARD_PIN);
REQUIRE_PIN(RIGHT_ENABLE_PIN);
REQUIRE_PIN(RIGHT_FORWARD_PIN);
REQUIRE_PIN(RIGHT_BACKWARD_PIN);
REQUIRE_PIN(LEFT_ENCODER_A_PIN);
REQUIRE_PIN(LEFT_ENCODER_B_PIN);
REQUIRE_PIN(RIGHT_ENCODER_A_PIN);
REQUIRE_PIN(RIGHT_ENCODER_B_PIN);
REQUIRE_PIN(SONAR_TRIGGER_PIN);
REQUIRE_PIN(SONAR_ECHO_PIN);

static_assert((LEFT_ENABLE_PIN == 9 && RIGHT_ENABLE_PIN == 10) || (LEFT_ENABLE_PIN == 10 && RIGHT_ENABLE_PIN == 9),
              "config.h: LEFT_ENABLE_PIN and RIGHT_ENABLE_PIN must be 9 and 10, or 10 and 9");
static_assert(BATTERY_PIN == NOT_WIRED || isWithin(BATTERY_PIN, A0, A0 + NUM_ANALOG_INPUTS - 1),
              "config.h: BATTERY_PIN: must be NOT_WIRED or an analog pin, A0 to A5");
static_assert(isWithin(START_DUTY, 0, 254), "config.h: START_DUTY is 0 to 254");
static_assert(isWithin(FULL_SPEED, 1, 1000), "config.h: FULL_SPEED is 1 to 1000");
static_assert(isWithin(DEADMAN_MS, 100, 5000), "config.h: DEADMAN_MS is 100 to 5000");
static_assert(isWithin(KP, 0, 1000) && isWithin(KD, 0, 1000) && isWithin(KI, 0, 1000) && isWithin(KO, 1, 1000),
              "config.h: KO is 1 to 1000, KP, KD and KI are 0 to 1000");
