/* Source of all addresses: data sheet of the ATmega328P, register summary. */
#include "pins.h"

#include <simavr/avr_ioport.h>
#include <stddef.h>

enum { TCCR0A = 0x44, OCR0A = 0x47, OCR0B, TCCR1A = 0x80, TCCR1B, ICR1L = 0x86, ICR1H, OCR1AL, OCR1BL = 0x8A };
enum { TCCR2A = 0xB0, OCR2A = 0xB3, OCR2B };

/* The timer's output that may take a pin over; `shift` is where its mode bits are in the control register. */
static const struct pwm {
	uint8_t pin, control, shift, compare, is_wide;
} pwms[] = {
	{ 3, TCCR2A, 4, OCR2B, 0 }, { 5, TCCR0A, 4, OCR0B, 0 }, { 6, TCCR0A, 6, OCR0A, 0 },
	{ 9, TCCR1A, 6, OCR1AL, 1 }, { 10, TCCR1A, 4, OCR1BL, 1 }, { 11, TCCR2A, 6, OCR2A, 0 },
};

static char port_of(int64_t pin)
{
	return pin < 8 ? 'D' : pin < 14 ? 'B' : 'C';
}

static int bit_of(int64_t pin)
{
	return pin < 8 ? pin : pin < 14 ? pin - 8 : pin - 14;
}

static const struct pwm *driving(avr_t *avr, int64_t pin)
{
	for (unsigned i = 0; i < sizeof(pwms) / sizeof(*pwms); i++)
		if (pwms[i].pin == pin && avr->data[pwms[i].control] >> pwms[i].shift & 2)
			return &pwms[i];
	return NULL;
}

static double word(avr_t *avr, uint8_t low)
{
	return avr->data[low] | avr->data[low + 1] << 8;
}

static double duty(avr_t *avr, const struct pwm *pwm)
{
	double top = pwm->is_wide && avr->data[TCCR1B] & 0x10 ? word(avr, ICR1L) : 255;
	double compare = pwm->is_wide ? word(avr, pwm->compare) : avr->data[pwm->compare];
	double share = top > compare ? compare / top : 1;

	return avr->data[pwm->control] >> pwm->shift & 1 ? 1 - share : share;
}

double pin_output(avr_t *avr, int64_t pin)
{
	avr_ioport_state_t port;
	const struct pwm *pwm = driving(avr, pin);
	int mask = 1 << bit_of(pin);

	avr_ioctl(avr, AVR_IOCTL_IOPORT_GETSTATE(port_of(pin)), &port);
	if (pwm && port.ddr & mask)
		return duty(avr, pwm);
	return port.port & mask ? 1 : 0; /* an input with its pull-up on is high too */
}

static avr_irq_t *irq_of(avr_t *avr, int64_t pin)
{
	return avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(port_of(pin)), bit_of(pin));
}

/* simavr lets a pull-up win over a level that was only fed in, at each write to the port; a level of a pull from
 * outside stays. */
void pin_drive(avr_t *avr, int64_t pin, int level)
{
	static avr_ioport_external_t ports[] = { { .name = 'B' }, { .name = 'C' }, { .name = 'D' } };
	avr_ioport_external_t *port = &ports[port_of(pin) - 'B'];
	int mask = 1 << bit_of(pin);

	port->mask |= mask;
	port->value = level ? port->value | mask : port->value & ~mask;
	avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(port_of(pin)), port);
	avr_raise_irq(irq_of(avr, pin), level);
}

void pin_watch(avr_t *avr, int64_t pin, avr_irq_notify_t call)
{
	avr_irq_register_notify(irq_of(avr, pin), call, avr);
}
