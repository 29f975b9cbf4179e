/* An ATmega328P at 16 MHz with a robot around it: main ELF LINK BENCH.
 *
 * The program makes LINK a link to the UART's pty. BENCH is a file with a `struct bench`. The program shares it with the
 * process that created the file. The program reads one command a line from stdin:
 *
 * pull, plug: disconnect or connect the serial line.
 * reset: press the reset button.
 * hang: the firmware stays at its instruction.
 * mark: print the time.
 *
 * The program ends at the end of stdin. It prints events on stdout; see event.h. It runs in real time. On a slow machine
 * it runs more slowly. */
#include <err.h>
#include <errno.h>
#include <fcntl.h>
#include <simavr/avr_adc.h>
#include <simavr/sim_elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "bench.h"
#include "line.h"
#include "sonar.h"
#include "event.h"
#include "wheels.h"

enum {
	HZ = 16000000,
	MILLIVOLT = 5000,
	STEP = 800,           /* wheels take a step of 50 us */
	STEPS_A_SLICE = 20,   /* the world outside is looked at every millisecond */
	LOOK = 32,            /* a pulse has its edges within 2 us */
	CREEP = 20,           /* so many times slower than real time */
	NAP_NS = 100000,
	BOOTLOADER = 0x7E00,  /* its place is empty, but for an endless loop */
};

static const uint16_t HERE = 0xCFFF; /* rjmp .-2 */

static struct bench *bench;
static avr_run_t run_normally;
static avr_cycle_count_t boots_until;

/* What simavr has to say goes to stderr, errors alone: stdout is ours. */
static void log_error(avr_t *avr, const int level, const char *format, va_list given)
{
	if (level == LOG_ERROR)
		vfprintf(stderr, format, given);
}

static avr_t *made(const char *elf)
{
	elf_firmware_t firmware = { 0 };

	avr_global_logger_set(log_error);
	avr_t *avr = avr_make_mcu_by_name("atmega328p");

	if (!avr || elf_read_firmware(elf, &firmware))
		errx(1, "%s is no firmware", elf);
	avr_init(avr);
	firmware.frequency = HZ;
	avr_load_firmware(avr, &firmware);
	avr->vcc = avr->avcc = avr->aref = MILLIVOLT;
	memcpy(avr->flash + BOOTLOADER, &HERE, sizeof HERE);
	run_normally = avr->run;
	return avr;
}

static struct bench *shared(const char *path)
{
	int file = open(path, O_RDWR | O_CLOEXEC);
	void *memory = mmap(NULL, sizeof(struct bench), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);

	if (file < 0 || memory == MAP_FAILED)
		err(1, "%s", path);
	return memory;
}

/* Outside of every interrupt, so that they are served: simavr's watchdog, unlike a real one, never resets a program that
 * keeps them off. */
static void hang(avr_t *avr)
{
	while (!avr->sreg[S_I])
		avr_run(avr);
	avr->pc = BOOTLOADER;
	print_event(avr, "hangs");
}

static void reset(avr_t *avr)
{
	line_flush();
	avr_reset(avr);
	boots_until = avr->cycle + (avr_cycle_count_t)(bench->bootloader_s * HZ);
	print_event(avr, "reset");
}

/* Run until that cycle, as the bootloader or as the sketch. */
static void run(avr_t *avr, avr_cycle_count_t end)
{
	while (avr->cycle < end) {
		if (avr->cycle < boots_until) {
			avr->cycle = end < boots_until ? end : boots_until;
			continue;
		}
		avr->run_cycle_limit = LOOK;
		if (avr->run != run_normally)
			print_event(avr, "watchdog"); /* this very call resets it */
		if (avr_run(avr) >= cpu_Done)
			errx(1, "the sketch has crashed the AVR at %04x", avr->pc);
		sonar_pass(avr, bench);
	}
}

static void obey(avr_t *avr, const char *word, const char *link)
{
	if (!strcmp(word, "pull"))
		line_pull(avr, link);
	else if (!strcmp(word, "plug"))
		line_plug(avr, link);
	else if (!strcmp(word, "reset"))
		reset(avr);
	else if (!strcmp(word, "hang"))
		hang(avr);
	else if (!strcmp(word, "mark"))
		print_event(avr, "mark");
	else
		warnx("%s?", word);
}

/* Execute the commands on stdin; return whether stdin is still open. */
static int listen_outside(avr_t *avr, const char *link)
{
	char said[256];
	ssize_t got = read(STDIN_FILENO, said, sizeof said - 1);

	if (got <= 0)
		return got < 0 && errno == EAGAIN;
	said[got] = 0;
	for (char *word = strtok(said, "\n"); word; word = strtok(NULL, "\n"))
		obey(avr, word, link);
	return 1;
}

static void slice(avr_t *avr)
{
	static avr_cycle_count_t until;

	for (int step = 0; step < STEPS_A_SLICE; step++) {
		run(avr, until += STEP);
		wheels_turn(avr, bench, (double)STEP / HZ);
		line_feed(avr);
	}
	avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + bench->battery), bench->battery_mv);
	bench->cycles = avr->cycle;
	bench->is_listening = avr->cycle >= boots_until;
}

/* Sleep while the AVR is ahead of real time; it does not catch up if it is behind. */
static void keep_real_time(avr_cycle_count_t cycle)
{
	static double zero;
	struct timespec now, nap = { 0 };

	clock_gettime(CLOCK_MONOTONIC, &now);
	double wall = now.tv_sec + now.tv_nsec / 1e9, ahead = (double)cycle / HZ + zero - wall;
	if (ahead < -0.005)
		zero -= ahead;
	nap.tv_nsec = ahead > 0 ? ahead * 1e9 : 0;
	if (nap.tv_nsec)
		nanosleep(&nap, NULL);
}

/* Return whether the AVR must wait for the driving program: it has not requested this time, or has not read the line. */
static int is_ahead(avr_cycle_count_t cycle)
{
	return bench->asked != UINT64_MAX && (cycle > bench->asked || line_is_unread());
}

/* Then run at a fraction of the speed: hardly any time passes for a busy program, or one that a busy machine
 * delays, and a program that waits for an answer gets it. */
static void creep(avr_cycle_count_t cycle)
{
	static const struct timespec nap = { .tv_nsec = NAP_NS };

	for (long slept = 0; slept < CREEP * 1000000L && is_ahead(cycle); slept += NAP_NS)
		nanosleep(&nap, NULL);
}

int main(int count, char **given)
{
	if (count != 4)
		errx(2, "usage: %s ELF LINK BENCH", given[0]);
	setlinebuf(stdout);
	fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
	avr_t *avr = made(given[1]);
	bench = shared(given[3]);
	line_wire(avr, bench);
	sonar_wire(avr, bench);
	line_plug(avr, given[2]);
	while (listen_outside(avr, given[2])) {
		if (line_exchange(avr) && bench->resets_when_opened)
			reset(avr);
		slice(avr);
		keep_real_time(avr->cycle);
		creep(avr->cycle);
	}
	line_pull(avr, given[2]);
	return 0;
}
