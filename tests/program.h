#pragma once
#include <functional>
#include <string>
#include <vector>

/// What a run of the program gave.
struct Outcome {
    int code = -1;          ///< exit code, or 128 + the signal that ended it.
    std::string out, err;   ///< standard output and standard error.
};

/// A run of the built program, with arguments as a user types them.
struct Launch {
    std::vector<std::string> arguments;
    std::string folder = ".";                               ///< working folder.
    std::vector<std::string> environment = {};              ///< NAME=VALUE, put over the inherited ones.
    std::function<void()> before_exec = [] {};              ///< runs in the child: limits, closed streams.
    std::function<void(int)> while_running = [](int) {};    ///< gets the process id.
};

/// Runs `firn` and waits for it, at most a minute (ten with sanitizers).
Outcome run_firn(const Launch&);
Outcome run_firn(const std::vector<std::string>& arguments);
