/* Two wheels: L298N, motor, encoder. */
#ifndef WHEELS_H
#define WHEELS_H

#include <simavr/sim_avr.h>

#include "bench.h"

/* Let the wheels turn for some seconds by the present levels of the pins, and feed the edges of their encoders.
 * Call it so often that an encoder has at most one edge in between. It prints `duty` if one changes. */
void wheels_turn(avr_t *avr, struct bench *bench, double seconds);

#endif
