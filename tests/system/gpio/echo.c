/* An ultrasonic module on simulated lines: answers every pulse on the trigger's line by a pulse on the echo's.
 *
 * echo VALUE PULL DELAY_US ECHO_US: the trigger's file `value`, the echo's file `pull`, the time from the pulse to
 * the echo, and the length of the echo. Runs until it is killed. Needs root for real-time priority, without which
 * it would miss pulses. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static int level(int file)
{
	char digit = '0';

	if (pread(file, &digit, 1, 0) != 1)
		exit(1);
	return digit == '1';
}

static void hold(int file, const char *pull, long microseconds)
{
	struct timespec now, end;

	clock_gettime(CLOCK_MONOTONIC, &end);
	end.tv_nsec += microseconds * 1000;
	end.tv_sec += end.tv_nsec / 1000000000;
	end.tv_nsec %= 1000000000;
	if (pwrite(file, pull, strlen(pull), 0) < 0)
		exit(1);
	do
		clock_gettime(CLOCK_MONOTONIC, &now);
	while (now.tv_sec < end.tv_sec || (now.tv_sec == end.tv_sec && now.tv_nsec < end.tv_nsec));
}

int main(int count, char **given)
{
	const struct sched_param priority = { .sched_priority = 1 };
	const struct timespec pause = { .tv_nsec = 40000 };
	int trigger, echo;

	if (count != 5 || (trigger = open(given[1], O_RDONLY)) < 0 || (echo = open(given[2], O_WRONLY)) < 0)
		return 2;
	if (sched_setscheduler(0, SCHED_FIFO, &priority))
		return 3;
	puts("ready");
	fflush(stdout);
	for (;;) {
		while (!level(trigger))
			nanosleep(&pause, NULL);
		while (level(trigger))
			;
		hold(echo, "pull-down", atol(given[3]));
		hold(echo, "pull-up", atol(given[4]));
		hold(echo, "pull-down", 0);
	}
}
