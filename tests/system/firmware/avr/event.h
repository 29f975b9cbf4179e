/* Print an event as a line on stdout: the time of the AVR in cycles, and the event. */
#ifndef EVENT_H
#define EVENT_H

#include <inttypes.h>
#include <simavr/sim_avr.h>
#include <stdio.h>

#define print_event(avr, ...) (printf("%" PRIu64 " ", (uint64_t)(avr)->cycle), printf(__VA_ARGS__), putchar('\n'))

#endif
