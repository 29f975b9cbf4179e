// The firmware of a board with two motors, encoders, a sonar and a battery. A computer on the USB line controls the
// board. config.h has the wiring, and commands.cpp has the commands. docs/firmware.md explains both.

#include <avr/wdt.h>

#include "commands.h"
#include "config.h"
#include "drive.h"
#include "encoders.h"
#include "sonar.h"

void setup() {
  drive::begin();
  MCUSR = 0; // otherwise the watchdog stays on after it has reset the chip
  wdt_disable();
  sonar::begin();
  Serial.begin(BAUD);
  wdt_enable(WDTO_120MS); // if the loop hangs for 120 ms, the chip is reset, and then no pin drives a motor
}

void loop() {
  wdt_reset();
  drive::poll();
  sonar::poll();
  if (Serial.available() > 0) commands::take(static_cast<char>(Serial.read()));
}

// The interrupt of a pin that `watch` has set up, on any port.
ISR(PCINT0_vect) {
  encoders::edge();
  sonar::edge();
}
ISR(PCINT1_vect, ISR_ALIASOF(PCINT0_vect));
ISR(PCINT2_vect, ISR_ALIASOF(PCINT0_vect));
