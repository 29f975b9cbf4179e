/* Wires on simulated lines: each copies the level of one line to the pull of another one.
 *
 * wires VALUE VALUE PULL [VALUE VALUE PULL ...]: the file `value` of the first end, and the files `value` and `pull`
 * of the second end. Runs until it is killed. Needs root for real-time priority. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define MOST 4

static int level(int file)
{
	char digit = '0';

	if (pread(file, &digit, 1, 0) != 1)
		exit(1);
	return digit == '1';
}

int main(int count, char **given)
{
	const struct sched_param priority = { .sched_priority = 1 };
	const struct timespec pause = { .tv_nsec = 50000 };
	int from[MOST], to[MOST], pull[MOST], wires = (count - 1) / 3;

	if (wires < 1 || wires > MOST)
		return 2;
	for (int each = 0; each < wires; each++) {
		from[each] = open(given[1 + 3 * each], O_RDONLY);
		to[each] = open(given[2 + 3 * each], O_RDONLY);
		pull[each] = open(given[3 + 3 * each], O_WRONLY);
		if (from[each] < 0 || to[each] < 0 || pull[each] < 0)
			return 2;
	}
	if (sched_setscheduler(0, SCHED_FIFO, &priority))
		return 3;
	puts("ready");
	fflush(stdout);
	for (;;) {
		for (int each = 0; each < wires; each++) {
			const int high = level(from[each]);
			const char *word = high ? "pull-up" : "pull-down";

			if (high != level(to[each]) && pwrite(pull[each], word, strlen(word), 0) < 0)
				exit(1);
		}
		nanosleep(&pause, NULL);
	}
}
