// The voltage of the battery, measured with a divider.
#pragma once
#include <stdint.h>

namespace battery {

// Returns the mean of eight measurements in mV, or -1 if no divider is wired. It takes 1 ms.
int32_t millivolts();

} // namespace battery
