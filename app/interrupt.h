#pragma once

namespace firn {

/// From now on the first SIGINT or SIGTERM is only noted; a second one ends the program at once.
void catch_interrupts();

/// The signal that was noted, or 0.
int interrupted();

}  // namespace firn
