// The commands of the computer, and their replies. docs/firmware.md has the table.
#pragma once

namespace commands {

// Takes the next byte of the line; if it ends a command, executes the command and replies.
void take(char byte);

} // namespace commands
