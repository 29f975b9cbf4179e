// The voltage of the battery, measured with a divider.
#pragma once
#include <stdint.h>

namespace battery {

// Returns the mean of eight measurements (1 ms) in mV; -1 if no divider is wired.
int32_t millivolts();

} // namespace battery
