#include "sonar.h"

#include <simavr/sim_time.h>

#include "pins.h"

/* From the end of the trigger to the rise of the echo: eight cycles at 40 kHz are sent, and some more. */
static const uint32_t BURST_US = 450;

static avr_cycle_count_t rises, rose; /* 0 where nothing is due */

static void triggered(avr_irq_t *irq, uint32_t level, void *given)
{
	avr_t *avr = given;

	if (!level && !rose)
		rises = avr->cycle + avr_usec_to_cycles(avr, BURST_US);
}

void sonar_wire(avr_t *avr, struct bench *bench)
{
	pin_drive(avr, bench->echo, 0);
	pin_watch(avr, bench->trigger, triggered);
}

void sonar_pass(avr_t *avr, struct bench *bench)
{
	if (rises && avr->cycle >= rises) {
		pin_drive(avr, bench->echo, 1);
		rose = rises;
		rises = 0;
	}
	if (rose && avr->cycle >= rose + (avr_cycle_count_t)(bench->echo_s * avr->frequency)) {
		pin_drive(avr, bench->echo, 0);
		rose = 0;
	}
}
