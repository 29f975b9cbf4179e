/* An HC-SR04: answers each pulse on its trigger by one on its echo. */
#ifndef SONAR_H
#define SONAR_H

#include <simavr/sim_avr.h>

#include "bench.h"

void sonar_wire(avr_t *avr, struct bench *bench);

/* Raise or lower the pin of the echo if that is due. */
void sonar_pass(avr_t *avr, struct bench *bench);

#endif
