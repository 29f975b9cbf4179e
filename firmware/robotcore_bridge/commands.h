// What the computer says, and what it is answered. docs/firmware.md has the table.
#pragma once

namespace commands {

// Takes the next byte of the line; where it ends a command, obeys and answers it.
void take(char byte);

} // namespace commands
