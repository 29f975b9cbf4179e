// Parses bytes into lines, and lines into commands; anything malformed is refused.
#pragma once
#include <stdint.h>

// One command: its letter, and the numbers after it.
struct Command {
  char name;
  uint8_t count;
  int16_t args[4];
  bool summed; // it has a checksum, which is right
};

// Collects bytes up to a CR. A line that is too long, or has a byte that no command has, is dropped whole.
class LineReader {
public:
  enum Result { NOTHING, LINE, SPOILT };

  // Takes the next byte. If it ends a line, returns LINE, and text() is the line, or SPOILT. An empty line and an LF
  // after a CR are ignored.
  Result take(char byte) {
    if (byte == '\r') return end();
    if (byte == '\n' && length == 0) return NOTHING;
    if (byte < ' ' || byte > '~' || length == sizeof(buffer) - 1) spoilt = true;
    else buffer[length++] = byte;
    return NOTHING;
  }

  const char *text() const { return buffer; }

private:
  Result end() {
    const Result result = spoilt ? SPOILT : length > 0 ? LINE : NOTHING;
    buffer[length] = '\0';
    length = 0;
    spoilt = false;
    return result;
  }

  char buffer[32];
  uint8_t length = 0;
  bool spoilt = false;
};

// Reads an integer of at most six digits, and moves text behind it. Returns whether it is a 16-bit number.
inline bool readNumber(const char *&text, int16_t &number) {
  const bool negative = *text == '-';
  if (negative) ++text;
  int32_t value = 0;
  uint8_t digits = 0;
  for (; *text >= '0' && *text <= '9' && digits < 6; ++text, ++digits) value = value * 10 + (*text - '0');
  number = static_cast<int16_t>(negative ? -value : value);
  return digits > 0 && value <= INT16_MAX;
}

inline int8_t hexDigit(char c) {
  return static_cast<int8_t>(c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1);
}

// Returns whether the two hexadecimal digits after the star are the XOR of the bytes from start up to the star.
inline bool sumIsRight(const char *start, const char *star) {
  uint8_t sum = 0;
  for (; start != star; ++start) sum ^= static_cast<uint8_t>(*start);
  const int8_t high = hexDigit(star[1]), low = high < 0 ? int8_t(-1) : hexDigit(star[2]);
  return low >= 0 && star[3] == '\0' && sum == (high << 4 | low);
}

// Parses a line: a letter, a space, up to four numbers separated by spaces (in `u` by colons), and perhaps a star and a
// checksum. Returns whether the line is such a command.
inline bool parse(const char *line, Command &command) {
  const char *text = line;
  command.name = *text++;
  for (command.count = 0; *text == (command.count > 0 && command.name == 'u' ? ':' : ' '); ++command.count) {
    if (command.count == 4 || !readNumber(++text, command.args[command.count])) return false;
  }
  command.summed = *text == '*';
  return command.summed ? sumIsRight(line, text) : *text == '\0';
}
