#include "tests/program.h"

#include "tests/sanitizers.h"
#include "tests/temp_folder.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

[[noreturn]] static void become_firn(const Launch& launch, const std::string& out, const std::string& err) {
    std::vector<char*> words{const_cast<char*>("firn")};
    for (const auto& argument : launch.arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    for (const auto& setting : launch.environment) ::putenv(const_cast<char*>(setting.c_str()));
    const int output = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int errors = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(output, 1), ::dup2(errors, 2);
    ::close(output), ::close(errors);
    if (::chdir(launch.folder.c_str()) != 0) ::_exit(126);
    launch.before_exec();
    ::execv(FIRN_PROGRAM, words.data());
    ::_exit(127);
}

Outcome run_firn(const Launch& launch) {
    const TempFolder streams;
    const pid_t child = ::fork();
    if (child == 0) become_firn(launch, streams / "out", streams / "err");
    launch.while_running(child);
    int status = 0;
    const auto begun = std::chrono::steady_clock::now();
    while (::waitpid(child, &status, WNOHANG) == 0) {
        if (std::chrono::steady_clock::now() - begun > std::chrono::minutes(tries(1, 10))) ::kill(child, SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return {code, bytes_of_file(streams / "out"), bytes_of_file(streams / "err")};
}

Outcome run_firn(const std::vector<std::string>& arguments) {
    Launch launch;
    launch.arguments = arguments;
    return run_firn(launch);
}
