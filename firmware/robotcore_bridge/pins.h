// Pins of the ATmega328P that call an interrupt at each change.
#pragma once
#include <Arduino.h>

#define NOT_WIRED 255

// Whether a pin is high; where the pin is a constant, in one instruction.
inline bool isHigh(uint8_t pin) {
  if (pin < 8) return PIND >> pin & 1;
  if (pin < 14) return PINB >> (pin - 8) & 1;
  return PINC >> (pin - 14) & 1;
}

// Makes it an input with its pull-up, so that a wire that fell off is a level that stays; any change of it calls the
// interrupts of robotcore_bridge.ino.
inline void watch(int8_t pin) {
  pinMode(static_cast<uint8_t>(pin), INPUT_PULLUP);
  *digitalPinToPCMSK(pin) |= bit(digitalPinToPCMSKbit(pin));
  *digitalPinToPCICR(pin) |= bit(digitalPinToPCICRbit(pin));
}
