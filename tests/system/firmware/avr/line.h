/* The UART on a pty, which a link leads to as long as the line is plugged in. */
#ifndef LINE_H
#define LINE_H

#include <simavr/sim_avr.h>

#include "bench.h"

void line_wire(avr_t *avr, struct bench *bench);

/* Put the link to a new pty; take link and pty away, as a line that is pulled. */
void line_plug(avr_t *avr, const char *link);
void line_pull(avr_t *avr, const char *link);

/* Take what the other end has written. Returns whether it has opened the line since the last call. */
int line_exchange(avr_t *avr);

/* Feed what was written into the UART, a byte in each byte's time. Tells `line` when a CR ends one. */
void line_feed(avr_t *avr);

/* Whether the other end has the line open and has yet to read something. */
int line_is_unread(void);

/* Forget what has not been fed. */
void line_flush(void);

#endif
