/* Two wheels: L298N, motor, encoder. */
#ifndef WHEELS_H
#define WHEELS_H

#include <simavr/sim_avr.h>

#include "bench.h"

/* Let them turn for so long, by what the pins say now, and feed the edges of their encoders.
 * Call it so often that an encoder has no more than one edge in between. Tells `duty` when one changes. */
void wheels_turn(avr_t *avr, struct bench *bench, double seconds);

#endif
