// A C interface to the parts of the firmware that do not use Arduino. Python tests call it on this computer.
#include "deadman.h"
#include "line.h"
#include "quadrature.h"
#include "speed.h"

extern "C" {

struct ParsedLine {
  int32_t ended; // LineReader::Result
  int32_t isCommand, name, count, hasChecksum;
  int32_t args[4];
};

LineReader *makeReader() { return new LineReader; }
void dropReader(LineReader *reader) { delete reader; }
ParsedLine take(LineReader *reader, char byte) {
  ParsedLine parsed{};
  parsed.ended = reader->take(byte);
  Command command{};
  if (parsed.ended != LineReader::LINE) return parsed;
  parsed.isCommand = parse(reader->text(), command);
  parsed.name = command.name;
  parsed.count = command.count;
  parsed.hasChecksum = command.hasChecksum;
  for (int i = 0; i < 4; ++i) parsed.args[i] = command.args[i];
  return parsed;
}

int32_t countEdges(const uint8_t *levels, int32_t length) {
  Quadrature wheel;
  wheel.begin(levels[0] >> 1 & 1, levels[0] & 1);
  for (int32_t i = 1; i < length; ++i) wheel.update(levels[i] >> 1 & 1, levels[i] & 1);
  return static_cast<int32_t>(wheel.count());
}

struct WatchedDeadman {
  Deadman deadman;
};
WatchedDeadman *makeDeadman(uint16_t ms) { return new WatchedDeadman{Deadman(ms)}; }
void dropDeadman(WatchedDeadman *it) { delete it; }
void feed(WatchedDeadman *it, uint32_t now) { it->deadman.feed(now); }
void disarm(WatchedDeadman *it) { it->deadman.disarm(); }
bool hasExpired(WatchedDeadman *it, uint32_t now) { return it->deadman.hasExpired(now); }

struct Controller {
  Gains gains;
  SpeedControl control;
  Controller(Wheel wheel, Gains gains) : gains(gains), control(wheel, this->gains) {}
};
Controller *makeController(int16_t start, int16_t full, int16_t kp, int16_t kd, int16_t ki, int16_t ko) {
  return new Controller({start, full}, {kp, kd, ki, ko});
}
void dropController(Controller *it) { delete it; }
void setTarget(Controller *it, int16_t speed) { it->control.setTarget(speed); }
int16_t step(Controller *it, int32_t counts) { return it->control.step(counts); }
}
