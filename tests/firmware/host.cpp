// The parts of the firmware that know no Arduino, for this computer: what they do is asked from Python.
#include "deadman.h"
#include "line.h"
#include "quadrature.h"
#include "speed.h"

extern "C" {

struct Understood {
  int32_t ended; // LineReader::Result
  int32_t isCommand, name, count, summed;
  int32_t args[4];
};

LineReader *reader() { return new LineReader; }
void dropReader(LineReader *reader) { delete reader; }
Understood take(LineReader *reader, char byte) {
  Understood understood{};
  understood.ended = reader->take(byte);
  Command command{};
  if (understood.ended != LineReader::LINE) return understood;
  understood.isCommand = parse(reader->text(), command);
  understood.name = command.name;
  understood.count = command.count;
  understood.summed = command.summed;
  for (int i = 0; i < 4; ++i) understood.args[i] = command.args[i];
  return understood;
}

int32_t counted(const uint8_t *levels, int32_t length) {
  Quadrature wheel;
  wheel.begin(levels[0] >> 1 & 1, levels[0] & 1);
  for (int32_t i = 1; i < length; ++i) wheel.update(levels[i] >> 1 & 1, levels[i] & 1);
  return static_cast<int32_t>(wheel.count());
}

struct Watched {
  Deadman deadman;
};
Watched *watched(uint16_t ms) { return new Watched{Deadman(ms)}; }
void dropWatched(Watched *it) { delete it; }
void feed(Watched *it, uint32_t now) { it->deadman.feed(now); }
void disarm(Watched *it) { it->deadman.disarm(); }
bool hasExpired(Watched *it, uint32_t now) { return it->deadman.hasExpired(now); }

struct Kept {
  Gains gains;
  SpeedControl control;
  Kept(Wheel wheel, Gains gains) : gains(gains), control(wheel, this->gains) {}
};
Kept *kept(int16_t start, int16_t full, int16_t kp, int16_t kd, int16_t ki, int16_t ko) {
  return new Kept({start, full}, {kp, kd, ki, ko});
}
void dropKept(Kept *it) { delete it; }
void setTarget(Kept *it, int16_t speed) { it->control.setTarget(speed); }
int16_t step(Kept *it, int32_t counts) { return it->control.step(counts); }
}
