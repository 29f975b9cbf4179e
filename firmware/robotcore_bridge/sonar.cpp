#include "sonar.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "config.h"
#include "pins.h"

namespace {

const uint32_t CYCLE_US = 60000;                       // from the sensor's manual, so that echoes fade in between
const uint32_t MAX_US = SONAR_MAX_MM * 2000UL / 343UL; // there and back at 343 m/s

volatile bool echoing = false, answered = false;
volatile uint32_t rose = 0, echo = 0; // us

bool waiting = false, measured = false;
uint32_t triggered = 0, heard = 0; // us, ms
int16_t newestMm = -1;

// Sets the trigger pin high for 10 us, unless the sensor is still busy with its last echo.
void trigger() {
  if (isHigh(SONAR_ECHO_PIN)) return;
  answered = false;
  waiting = true;
  digitalWrite(SONAR_TRIGGER_PIN, HIGH);
  delayMicroseconds(10);
  digitalWrite(SONAR_TRIGGER_PIN, LOW);
}

// Stores a measurement: the duration of the pulse on the echo pin in us. Without an echo, the pulse is 38 ms or longer.
// A sensor that is not connected sends no pulse, so there is no measurement.
void store(uint32_t length) {
  waiting = false;
  measured = true;
  heard = millis();
  newestMm = length > MAX_US ? -1 : static_cast<int16_t>(length * 343 / 2000);
}

} // namespace

void sonar::begin() {
  pinMode(SONAR_TRIGGER_PIN, OUTPUT);
  watch(SONAR_ECHO_PIN);
}

void sonar::edge() {
  const bool high = isHigh(SONAR_ECHO_PIN);
  if (high == echoing) return;
  echoing = high;
  if (high) {
    rose = micros();
  } else {
    echo = micros() - rose;
    answered = true;
  }
}

void sonar::poll() {
  bool done = false;
  uint32_t length = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    done = answered;
    length = echo;
  }
  const uint32_t now = micros();
  if (waiting && done) store(length);
  if (now - triggered < CYCLE_US) return;
  triggered = now;
  trigger();
}

sonar::Range sonar::newest() {
  const uint32_t age = millis() - heard;
  return {newestMm, static_cast<uint16_t>(measured && age < UINT16_MAX ? age : UINT16_MAX)};
}
