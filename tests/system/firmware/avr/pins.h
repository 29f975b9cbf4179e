/* The pins of an Arduino Uno or Nano, by Arduino's numbers, for the parts that are wired to them. */
#ifndef PINS_H
#define PINS_H

#include <simavr/sim_avr.h>
#include <stdint.h>

/* Return the output of a pin, 0 to 1: the mean of its PWM, its level, or its pull-up. */
double pin_output(avr_t *avr, int64_t pin);

/* Drive a pin from outside, 0 or 1; the AVR's own pull-up does not change that. */
void pin_drive(avr_t *avr, int64_t pin, int level);

/* Call a function after each change of the level of a pin. */
void pin_watch(avr_t *avr, int64_t pin, avr_irq_notify_t call);

#endif
