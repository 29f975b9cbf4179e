// Parses bytes into lines, and lines into commands. A malformed line is refused.
#pragma once
#include <stdint.h>

// A command: its letter, and the numbers after the letter.
struct Command {
  char name;
  uint8_t count;
  int16_t args[4];
  bool hasChecksum; // the checksum is right
};

// Collects bytes up to a CR. A line that is too long, or that has a byte outside printable ASCII, is dropped whole.
class LineReader {
public:
  enum Result { NOTHING, LINE, DROPPED };

  // Takes the next byte. Returns LINE if the byte ends a line, which text() then returns. Returns DROPPED if the byte
  // ends a line that is dropped. An empty line and an LF after a CR are ignored.
  Result take(char byte) {
    if (byte == '\r') return end();
    if (byte == '\n' && length == 0) return NOTHING;
    if (byte < ' ' || byte > '~' || length == sizeof(buffer) - 1) isDropped = true;
    else buffer[length++] = byte;
    return NOTHING;
  }

  const char *text() const { return buffer; }

private:
  Result end() {
    const Result result = isDropped ? DROPPED : length > 0 ? LINE : NOTHING;
    buffer[length] = '\0';
    length = 0;
    isDropped = false;
    return result;
  }

  char buffer[32];
  uint8_t length = 0;
  bool isDropped = false;
};

// Reads an integer of at most six digits, and sets text to the character after it. Returns whether the integer fits
// into 16 bits.
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
inline bool isChecksumRight(const char *start, const char *star) {
  uint8_t sum = 0;
  for (; start != star; ++start) sum ^= static_cast<uint8_t>(*start);
  const int8_t high = hexDigit(star[1]), low = high < 0 ? int8_t(-1) : hexDigit(star[2]);
  return low >= 0 && star[3] == '\0' && sum == (high << 4 | low);
}

// Parses a line into a command, and returns whether the line has the form of a command. The form is a letter, a space,
// up to four numbers separated by spaces (in `u` by colons), and optionally a star and a checksum.
inline bool parse(const char *line, Command &command) {
  const char *text = line;
  command.name = *text++;
  for (command.count = 0; *text == (command.count > 0 && command.name == 'u' ? ':' : ' '); ++command.count) {
    if (command.count == 4 || !readNumber(++text, command.args[command.count])) return false;
  }
  command.hasChecksum = *text == '*';
  return command.hasChecksum ? isChecksumRight(line, text) : *text == '\0';
}
