// Executes the commands of the computer and replies to them. docs/firmware.md has the table of commands.
#pragma once

namespace commands {

// Takes the next received byte. If the byte ends a command, executes the command and replies.
void take(char byte);

} // namespace commands
