#include "battery.h"

#include <Arduino.h>

#include "config.h"
#include "pins.h"

int32_t battery::millivolts() {
  if (BATTERY_PIN == NOT_WIRED) return -1;
  int32_t sum = 0;
  for (uint8_t i = 0; i < 8; ++i) sum += analogRead(BATTERY_PIN);
  return sum * BATTERY_FULL_SCALE_MV / (8 * 1024L);
}
