/* The pins of an Arduino Uno or Nano, by Arduino's numbers, as what is wired to them sees them. */
#ifndef PINS_H
#define PINS_H

#include <simavr/sim_avr.h>
#include <stdint.h>

/* What comes out of a pin, 0 to 1: the mean of its PWM, its level, or its pull-up. */
double pin_output(avr_t *avr, int64_t pin);

/* Where a level is fed into a pin, or watched on it. */
avr_irq_t *pin_irq(avr_t *avr, int64_t pin);

#endif
