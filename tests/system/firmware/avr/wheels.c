#include "wheels.h"

#include <math.h>

#include "pins.h"
#include "event.h"

/* Equal inputs brake: the target is zero velocity, with the lag of the motor. */
static double duty(avr_t *avr, const struct wheel *wheel)
{
	double enable = wheel->enable < 0 ? 1 : pin_output(avr, wheel->enable);

	return enable * (pin_output(avr, wheel->forward) - pin_output(avr, wheel->backward));
}

static double target_rad_s(const struct wheel *wheel)
{
	double above = fmax(0, fabs(wheel->duty) - wheel->dead_band) / (1 - wheel->dead_band);

	return copysign(above * wheel->full_rad_s, wheel->duty);
}

static void roll(struct wheel *wheel, double seconds)
{
	double target = target_rad_s(wheel), decay = exp(-seconds / wheel->lag_s);
	double over = wheel->velocity_rad_s - target;

	wheel->angle_rad += target * seconds + over * wheel->lag_s * (1 - decay);
	wheel->velocity_rad_s = target + over * decay;
}

static void show(avr_t *avr, const struct wheel *wheel)
{
	int64_t quarter = (int64_t)floor(wheel->angle_rad * wheel->edges_per_turn / (2 * M_PI)) & 3;

	pin_drive(avr, wheel->a, quarter == 1 || quarter == 2);
	pin_drive(avr, wheel->b, quarter >= 2);
}

void wheels_turn(avr_t *avr, struct bench *bench, double seconds)
{
	double left = duty(avr, &bench->left), right = duty(avr, &bench->right);

	if (left != bench->left.duty || right != bench->right.duty)
		print_event(avr, "duty %.4f %.4f", left, right);
	bench->left.duty = left;
	bench->right.duty = right;
	for (struct wheel *wheel = &bench->left; wheel <= &bench->right; wheel++) {
		roll(wheel, seconds);
		show(avr, wheel);
	}
}
