// Two wheels with encoders, a sonar and a battery, for a computer at the other end of the USB line.
// The wiring is in config.h, the commands are in commands.cpp; docs/firmware.md explains both.

#include <avr/wdt.h>

#include "commands.h"
#include "config.h"
#include "drive.h"
#include "encoders.h"
#include "sonar.h"

void setup() {
  drive::begin();
  MCUSR = 0; // else the watchdog that has reset us stays on
  wdt_disable();
  sonar::begin();
  Serial.begin(BAUD);
  wdt_enable(WDTO_120MS); // a loop that hangs for so long resets the chip: no pin drives a motor then
}

void loop() {
  wdt_reset();
  drive::poll();
  sonar::poll();
  if (Serial.available() > 0) commands::take(static_cast<char>(Serial.read()));
}

// A watched pin has changed, on whichever port.
ISR(PCINT0_vect) {
  encoders::edge();
  sonar::edge();
}
ISR(PCINT1_vect, ISR_ALIASOF(PCINT0_vect));
ISR(PCINT2_vect, ISR_ALIASOF(PCINT0_vect));
