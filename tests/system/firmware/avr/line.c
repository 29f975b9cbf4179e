#define _GNU_SOURCE
#include "line.h"

#include <err.h>
#include <fcntl.h>
#include <poll.h>
#include <simavr/avr_uart.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "event.h"

enum { UCSR0A = 0xC0, U2X0 = 0x02, UBRR0L = 0xC4, UBRR0H, BITS_A_BYTE = 10, CR = 13 };

static struct bench *bench;
static int master = -1, is_open;
static unsigned char waiting[64];
static size_t fed, filled;
static avr_cycle_count_t next_byte;
static char text[64];
static size_t written;

/* Damage a byte at random: drop it, flip a bit, or flip a bit and add a byte. */
static size_t carried(unsigned char byte, unsigned char out[2])
{
	out[0] = byte;
	if (drand48() >= bench->noise)
		return 1;
	out[0] ^= 1 << lrand48() % 8;
	out[1] = lrand48();
	return lrand48() % 3;
}

static void sent(avr_irq_t *irq, uint32_t byte, void *given)
{
	unsigned char out[2];
	size_t length = carried(byte, out);

	if (master >= 0 && is_open)
		(void)!write(master, out, length); /* lost if the buffer is full, as on a wire */
}

void line_wire(avr_t *avr, struct bench *robot)
{
	uint32_t flags = 0; /* no echo on stdout, no naps */

	bench = robot;
	avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
	avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), sent, NULL);
}

void line_plug(avr_t *avr, const char *link)
{
	struct termios raw;

	if (master >= 0)
		return;
	master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	if (master < 0 || grantpt(master) || unlockpt(master) || tcgetattr(master, &raw))
		err(1, "no pty");
	cfmakeraw(&raw);
	tcsetattr(master, TCSANOW, &raw);
	close(open(ptsname(master), O_RDWR | O_NOCTTY)); /* so that poll detects if a process has it open */
	if (symlink(ptsname(master), link))
		err(1, "%s", link);
	print_event(avr, "plugged");
}

void line_pull(avr_t *avr, const char *link)
{
	if (master < 0)
		return;
	unlink(link);
	close(master);
	master = -1;
	is_open = 0;
	print_event(avr, "pulled");
}

void line_flush(void)
{
	fed = filled = 0;
	written = 0;
}

int line_exchange(avr_t *avr)
{
	struct pollfd looked = { .fd = master, .events = POLLIN };
	int was_open = is_open;
	ssize_t got;

	if (master < 0 || poll(&looked, 1, 0) < 0)
		return 0;
	is_open = !(looked.revents & POLLHUP);
	if (fed == filled) {
		fed = filled = 0;
		if ((got = read(master, waiting, sizeof waiting)) > 0)
			filled = got;
	}
	return is_open && !was_open;
}

/* Only the other end of the pty has the number of unread bytes, so this function opens that end briefly. */
int line_is_unread(void)
{
	int unread = 0, end = is_open ? ioctl(master, TIOCGPTPEER, O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC) : -1;

	if (end < 0)
		return 0;
	ioctl(end, FIONREAD, &unread);
	close(end);
	return unread > 0;
}

static avr_cycle_count_t byte_cycles(avr_t *avr)
{
	int divisor = (avr->data[UBRR0L] | avr->data[UBRR0H] << 8) + 1;

	return divisor * (avr->data[UCSR0A] & U2X0 ? 8 : 16) * BITS_A_BYTE;
}

static void note(avr_t *avr, unsigned char byte)
{
	if (byte != CR && written < sizeof text - 1) {
		text[written++] = byte >= ' ' && byte <= '~' ? byte : '?';
		return;
	}
	text[written] = 0;
	written = 0;
	print_event(avr, "line %s", text);
}

void line_feed(avr_t *avr)
{
	avr_irq_t *input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);

	if (next_byte < avr->cycle && fed == filled)
		next_byte = avr->cycle;
	for (; fed < filled && next_byte <= avr->cycle; next_byte += byte_cycles(avr)) {
		unsigned char in[2];
		size_t length = carried(waiting[fed++], in);

		for (size_t i = 0; i < length; i++) {
			avr_raise_irq(input, in[i]);
			note(avr, in[i]);
		}
	}
}
