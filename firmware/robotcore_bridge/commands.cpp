#include "commands.h"

#include <Arduino.h>

#include "battery.h"
#include "config.h"
#include "drive.h"
#include "encoders.h"
#include "line.h"
#include "sonar.h"

namespace {

// Writes to the serial line, and computes the checksum of the written bytes.
class Reply : public Print {
public:
  size_t write(uint8_t byte) override {
    sum ^= byte;
    return Serial.write(byte);
  }

  void printPair(int32_t first, int32_t second) {
    print(first);
    print(' ');
    print(second);
  }

  void end(bool hasChecksum) {
    const uint8_t total = sum;
    if (hasChecksum) {
      print(total < 16 ? F("*0") : F("*"));
      print(total, HEX);
    }
    println();
  }

private:
  uint8_t sum = 0;
};

LineReader line;
bool requiresChecksum = false;

bool has(const Command &command, uint8_t count, int16_t low = 0, int16_t high = 0) {
  if (command.count != count) return false;
  for (uint8_t i = 0; i < count; ++i) {
    if (command.args[i] < low || command.args[i] > high) return false;
  }
  return true;
}

bool isStop(const Command &command) { return (command.name == 'm' || command.name == 'o') && has(command, 2); }

bool setSpeed(const Command &command) {
  if (!has(command, 2, -drive::MAX_SPEED, drive::MAX_SPEED)) return false;
  drive::atSpeed(command.args[0], command.args[1]);
  return true;
}

bool setDuty(const Command &command) {
  if (!has(command, 2, -drive::MAX_DUTY, drive::MAX_DUTY)) return false;
  drive::atDuty(command.args[0], command.args[1]);
  return true;
}

bool setGains(const Command &command) {
  if (!has(command, 4, 0, 1000) || command.args[3] == 0) return false;
  drive::setGains({command.args[0], command.args[1], command.args[2], command.args[3]});
  return true;
}

bool setDeadman(const Command &command) {
  if (!has(command, 1, 100, 5000)) return false;
  drive::setDeadman(static_cast<uint16_t>(command.args[0]));
  return true;
}

bool resetCounts(const Command &command) {
  if (!has(command, 0)) return false;
  encoders::reset();
  return true;
}

// Replies as ROSArduinoBridge does: in cm, and 0 without a recent echo.
bool replyCentimetres(const Command &command, Reply &reply) {
  if (!has(command, 1, SONAR_TRIGGER_PIN, SONAR_TRIGGER_PIN) && !has(command, 1, SONAR_ECHO_PIN, SONAR_ECHO_PIN))
    return false;
  const sonar::Range range = sonar::newest();
  reply.print(range.mm < 0 || range.age > 500 ? 0 : range.mm / 10);
  return true;
}

bool replyValue(const Command &command, Reply &reply) {
  if (command.name == 'p') return replyCentimetres(command, reply);
  if (!has(command, 0)) return false;
  switch (command.name) {
  case 'b': reply.print(static_cast<int32_t>(BAUD)); return true;
  case 'e': reply.printPair(encoders::count(LEFT), encoders::count(RIGHT)); return true;
  case 'v': reply.print(F("robotcore-bridge 1")); return true;
  case 'y': reply.print(battery::millivolts()); return true;
  case 'z': {
    const sonar::Range range = sonar::newest();
    reply.printPair(range.mm, range.age);
    return true;
  }
  default: return false;
  }
}

bool set(const Command &command) {
  switch (command.name) {
  case 'm': return setSpeed(command);
  case 'o': return setDuty(command);
  case 'u': return setGains(command);
  case 'k': return setDeadman(command);
  case 'r': return resetCounts(command);
  default: return false;
  }
}

// After the first command with a checksum, commands without one are refused, because noise may have removed the
// checksum. A stop is always executed. A `v` without a checksum comes from another program, which uses no checksums.
bool isAccepted(const Command &command) {
  if (command.hasChecksum) requiresChecksum = true;
  else if (command.name == 'v') requiresChecksum = false;
  return command.hasChecksum || !requiresChecksum || isStop(command);
}

void execute(bool whole) {
  Command command{};
  Reply reply;
  const bool isCommand = whole && parse(line.text(), command);
  if (isCommand && isAccepted(command) && set(command)) reply.print(F("OK"));
  else if (!isCommand || !replyValue(command, reply)) reply.print(F("Invalid Command"));
  reply.end(command.hasChecksum);
}

} // namespace

void commands::take(char byte) {
  const LineReader::Result result = line.take(byte);
  if (result != LineReader::NOTHING) execute(result == LineReader::LINE);
}
