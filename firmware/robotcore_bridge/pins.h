// Reads pins of the ATmega328P, and lets each change of a pin raise an interrupt.
#pragma once
#include <Arduino.h>

#define NOT_WIRED 255

// Returns whether a pin is high. The compiler needs one instruction for it if the pin is a constant.
inline bool isHigh(uint8_t pin) {
  if (pin < 8) return PIND >> pin & 1;
  if (pin < 14) return PINB >> (pin - 8) & 1;
  return PINC >> (pin - 14) & 1;
}

// Makes a pin an input with its pull-up, so that a loose wire has a constant level. Each change of the pin then raises
// an interrupt of robotcore_bridge.ino.
inline void watch(int8_t pin) {
  pinMode(static_cast<uint8_t>(pin), INPUT_PULLUP);
  *digitalPinToPCMSK(pin) |= bit(digitalPinToPCMSKbit(pin));
  *digitalPinToPCICR(pin) |= bit(digitalPinToPCICRbit(pin));
}
