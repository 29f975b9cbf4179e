/* The UART on a pty. A link leads to the pty while the line is connected. */
#ifndef LINE_H
#define LINE_H

#include <simavr/sim_avr.h>

#include "bench.h"

void line_wire(avr_t *avr, struct bench *bench);

/* Create a pty and a link to it. Remove both, as if the cable was disconnected. */
void line_plug(avr_t *avr, const char *link);
void line_pull(avr_t *avr, const char *link);

/* Read the bytes that the driver has sent. Returns whether the driver has opened the line since the last call. */
int line_exchange(avr_t *avr);

/* Pass the bytes that were read to the UART, at the speed of the line. */
void line_feed(avr_t *avr);

/* Return whether the driver has the line open and has not read all bytes. */
int line_is_unread(void);

/* Discard the bytes that were not passed to the UART yet. */
void line_flush(void);

#endif
