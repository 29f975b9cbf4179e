/* What the simulated robot is and does: memory shared with the program that asked for it (bench.py has the same
 * structure). Every field has 8 bytes, so that each is read and written whole. Pins are Arduino's numbers. */
#ifndef BENCH_H
#define BENCH_H

#include <stdint.h>

/* A channel of an L298N, its motor, its wheel, and the encoder on that. */
struct wheel {
	/* as it is built */
	int64_t forward, backward, enable; /* the channel's inputs; enable is -1 where its jumper is on */
	int64_t a, b;                      /* the encoder's channels; forward, a leads */
	double dead_band;                  /* the duty at which it only just stands */
	double full_rad_s, lag_s;
	double edges_per_turn;
	/* what it does */
	double duty; /* -1 to 1, of what the pins say */
	double velocity_rad_s, angle_rad;
};

struct bench {
	struct wheel left, right;
	int64_t trigger, echo; /* of the HC-SR04 */
	int64_t battery;       /* the analog channel behind the battery's divider */
	int64_t resets_when_opened; /* as a board does whose DTR is wired to its reset */
	double battery_ratio;       /* of the divider before that; for whoever tells the voltage */
	double bootloader_s;        /* how long a board that was reset listens to nobody */
	double echo_s;              /* told from outside: how long the echo's pulse is */
	double battery_mv;          /* told from outside: at the analog pin */
	double noise;               /* told from outside: the share of bytes that the line spoils, both ways */
	uint64_t cycles;            /* the AVR's time */
	uint64_t asked;             /* told from outside: until when somebody waits for it; then it creeps. All ones: it runs */
	int64_t is_listening;       /* whether the bootloader has handed over */
};

#endif
