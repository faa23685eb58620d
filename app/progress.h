#pragma once
#include "app/record.h"

#include <chrono>
#include <string>

namespace firn {

enum class ProgressStyle {
    automatic,  ///< a bar on a terminal, else a line every 20 s.
    json,       ///< a JSON object a frame, one a line.
    none,
};

/// Tells on standard error how far a run is. Failures to write there are ignored.
class Progress {
public:
    explicit Progress(ProgressStyle);
    ~Progress() { end(); }

    void begin(double frames_done, int last_frame);                     ///< The run goes from here to there.
    void step(const StepReport&, double frames_done, double time);      ///< `time` simulated so far [s].
    void frame(const FrameRecord&);                                     ///< A frame was reached.
    void picture(int drawn);        ///< So many pictures are on their way.
    void note(const std::string&);  ///< For people: silent with json and none.
    void warning(const std::string&);                                   ///< Always told.
    void end();                                                         ///< Takes the bar away.

private:
    using Clock = std::chrono::steady_clock;
    std::string status() const;
    void draw(const std::string& line);
    void forget_troubles();
    double seconds_left() const;

    ProgressStyle style_;
    bool terminal_ = false, bar_shown_ = false;
    Clock::time_point begun_, told_;
    double first_ = 0, done_ = 0, time_ = 0;
    int last_ = 0;
    long steps_ = 0, steps_told_ = 0;
    StepReport newest_;
    double steps_per_second_ = 0;
    long rejected_ = 0, unconverged_ = 0, steps_clean_ = 0;     // since they were last told, when there were so many steps
};

/// "2 h 5 min", "1 min 20 s", "3.2 s"
std::string duration(double seconds);

/// Writes to standard error, whatever becomes of it.
void tell(const std::string& text);

/// The same for a JSON object, as one line; bytes of names that are not UTF-8 are replaced.
void tell_json(const nlohmann::ordered_json&);

}  // namespace firn
