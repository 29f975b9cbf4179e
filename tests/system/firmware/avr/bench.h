/* The simulated robot: memory shared with the program that started it (simulated.py has the same
 * structure). Every field has 8 bytes, so that each is read and written whole. Pins are Arduino's numbers. */
#ifndef BENCH_H
#define BENCH_H

#include <stdint.h>

/* A channel of an L298N, its motor, its wheel, and the encoder on that. */
struct wheel {
	/* as it is built */
	int64_t forward, backward, enable; /* the channel's inputs; enable is -1 if its jumper is on */
	int64_t a, b;                      /* the encoder's channels; forward, a leads */
	double dead_band;                  /* the greatest duty at which it stands */
	double full_rad_s, lag_s;
	double edges_per_turn;
	/* what it does */
	double duty; /* -1 to 1, by the pins */
	double velocity_rad_s, angle_rad;
};

struct bench {
	struct wheel left, right;
	int64_t trigger, echo; /* of the HC-SR04 */
	int64_t battery;       /* the analog channel behind the battery's divider */
	int64_t resets_when_opened; /* whether DTR is wired to the reset */
	double battery_ratio;       /* of the divider before that; for setting the voltage */
	double bootloader_s;        /* the time after a reset in which data is ignored */
	double echo_s;              /* input: how long the echo's pulse is */
	double battery_mv;          /* input: at the analog pin */
	double noise;               /* input: the share of damaged bytes on the line */
	uint64_t cycles;            /* the AVR's time */
	uint64_t asked;             /* input: the requested time, after which the AVR runs slowly; all ones for no limit */
	int64_t is_listening;       /* whether the bootloader has handed over */
};

#endif
