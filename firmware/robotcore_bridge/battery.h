// The battery's voltage, by a divider.
#pragma once
#include <stdint.h>

namespace battery {

// In mV, the mean of eight looks (1 ms); -1 where no divider is wired.
int32_t millivolts();

} // namespace battery
