#include "app/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace firn {

using Seconds = std::chrono::duration<double>;

void tell(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stderr) == text.size()) std::fflush(stderr);
}

void tell_json(const nlohmann::ordered_json& json) {
    tell(json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::string duration(double seconds) {
    if (!(seconds < 1e9)) return "for ever";
    const auto whole = static_cast<long>(std::llround(seconds));
    if (whole >= 3600) return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
    if (whole >= 60) return fmt::format("{} min {} s", whole / 60, whole % 60);
    return fmt::format("{:.1f} s", seconds);
}

static std::size_t terminal_columns() {
    winsize size{};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

Progress::Progress(ProgressStyle style)
    : style_(style), terminal_(style == ProgressStyle::automatic && ::isatty(STDERR_FILENO)) {}

void Progress::begin(double frames_done, int last_frame) {
    begun_ = told_ = Clock::now();
    first_ = done_ = frames_done;
    last_ = last_frame;
}

double Progress::seconds_left() const {
    const double spent = Seconds(Clock::now() - begun_).count();
    return done_ > first_ ? spent * (last_ - done_) / (done_ - first_) : INFINITY;
}

std::string Progress::status() const {
    std::string line = fmt::format("frame {}/{} t {:.3f} s dt {:.1e} s {:.0f} steps/s",
                                   static_cast<int>(done_), last_, time_, newest_.dt, steps_per_second_);
    if (newest_.iterations > 0) line += fmt::format(" {} iter.", newest_.iterations);
    if (done_ > first_ && done_ < last_) line += fmt::format(" {} left", duration(seconds_left()));
    return line + Troubles{steps_ - steps_clean_, rejected_, unconverged_}.text();
}

void Progress::draw(const std::string& line) {
    const std::size_t width = terminal_columns(), taken = line.size() + 4;
    const std::size_t length = std::clamp<std::size_t>(width > taken ? width - taken : 0, 8, 40);
    const double share = last_ > 0 ? std::clamp(done_ / last_, 0.0, 1.0) : 1;
    const auto full = static_cast<std::size_t>(share * static_cast<double>(length));
    const std::string bar =
        fmt::format("[{}{}] {}", std::string(full, '='), std::string(length - full, ' '), line);
    tell("\r\x1b[K" + bar.substr(0, width - 1));
    bar_shown_ = true;
}

void Progress::step(const StepReport& report, double frames_done, double time) {
    newest_ = report, done_ = frames_done, time_ = time;
    ++steps_;
    rejected_ += report.rejected, unconverged_ += !report.converged;
    const double since = Seconds(Clock::now() - told_).count();
    if (style_ != ProgressStyle::automatic || since < (terminal_ ? 0.2 : 20)) return;
    steps_per_second_ = static_cast<double>(steps_ - steps_told_) / since;
    if (terminal_) {
        draw(status());
    } else {
        tell(status() + "\n");
        forget_troubles();
    }
    steps_told_ = steps_, told_ = Clock::now();
}

void Progress::frame(const FrameRecord& r) {
    if (style_ == ProgressStyle::json) {
        const double seconds = r.simulate_seconds;
        nlohmann::ordered_json line{
            {"event", "frame"},
            {"frame", r.frame},
            {"last_frame", last_},
            {"time", r.time},
            {"dt", newest_.dt},
            {"steps", r.steps},
            {"steps_per_second", seconds > 0 ? static_cast<double>(r.steps) / seconds : 0.0},
            {"iterations", r.solver_iterations},
            {"unconverged", unconverged_},
            {"rejected", rejected_},
            {"seconds_left",
             std::isfinite(seconds_left()) ? nlohmann::ordered_json(seconds_left()) : nullptr}};
        tell_json(line);
        forget_troubles();
    }
    if (terminal_ && (unconverged_ > 0 || rejected_ > 0)) {
        note(fmt::format("frame {}{}", r.frame, Troubles{steps_ - steps_clean_, rejected_, unconverged_}.text()));
        forget_troubles();
    }
}

void Progress::picture(int drawn) {
    done_ = drawn;
    if (style_ == ProgressStyle::json)
        tell_json(nlohmann::ordered_json{{"event", "picture"}, {"drawn", drawn}, {"of", last_}});
    const double since = Seconds(Clock::now() - told_).count();
    if (style_ != ProgressStyle::automatic || since < (terminal_ ? 0.2 : 20)) return;
    const std::string line = fmt::format("picture {}/{}  {} left", drawn, last_, duration(seconds_left()));
    if (terminal_) draw(line);
    else tell(line + "\n");
    told_ = Clock::now();
}

void Progress::note(const std::string& text) {
    if (style_ != ProgressStyle::automatic) return;
    end();
    tell(text + "\n");
}

void Progress::warning(const std::string& text) {
    end();
    if (style_ == ProgressStyle::json)
        tell_json(nlohmann::ordered_json{{"event", "warning"}, {"message", text}});
    else tell(text + "\n");
}

void Progress::forget_troubles() { rejected_ = unconverged_ = 0, steps_clean_ = steps_; }

void Progress::end() {
    if (bar_shown_) tell("\r\x1b[K");
    bar_shown_ = false;
}

}  // namespace firn
