#include "app/interrupt.h"

#include <unistd.h>

#include <csignal>

namespace firn {

static volatile std::sig_atomic_t noted = 0;

static void note(int signal) {
    if (noted != 0) ::_exit(128 + signal);
    noted = signal;
}

void catch_interrupts() {
    struct sigaction action{};
    action.sa_handler = note;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
}

int interrupted() { return noted; }

}  // namespace firn
