#include "app/commands.h"
#include "app/files.h"
#include "app/machine.h"
#include "sim/simulation.h"

#include <fmt/format.h>
#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <regex>

namespace firn {
namespace {

// A ball at 8 particles a cell that has reached a sticky wall.
constexpr double radius = 0.5, speed = 8;

struct Trial {
    const char* name;
    Solver solver;
    int threads;
    double particles;
    int balls = 1;                      // that many parts of it, far from each other
    bool bed = false;                   // beside nine times as much snow at rest, without gravity
    std::unique_ptr<Simulation> simulation{};
    double bytes = 0;                   // a particle
    std::vector<PhaseSeconds> steps{};
    std::vector<double> iteration{};    // seconds of a solve for each of its iterations
};

double resident_bytes() {
    malloc_trim(0);
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void set_up(Trial& t) {
    const double before = resident_bytes(), r = radius / std::cbrt(t.balls);
    Setup setup;
    setup.h = std::cbrt(4 * M_PI / 3 * radius * radius * radius / t.particles * 8);
    setup.solver = t.solver;
    setup.materials = {Snow{}};
    Collider wall;
    wall.shape = Plane{{r + setup.h, 0, 0}, {-1, 0, 0}};
    wall.contact = ContactLaw::sticky;
    setup.colliders = {wall};
    ParticleSet start;
    if (t.bed) {
        Body bed;
        const double width = std::cbrt(4 * M_PI / 3 * 9 * 4) * radius;
        bed.shape = Box{{-2 * radius - width / 2, 0, 0}, {width, width / 4, width}};
        start.append(sample(bed, 400, setup.h, 2, 0));
        setup.gravity = {0, 0, 0};
    }
    for (int n = 0; n < t.balls; ++n) {
        Body b;
        b.shape = Sphere{{-6.0 * radius * (n / 4), 6.0 * radius * (n / 2 % 2), 6.0 * radius * (n % 2)}, r};
        b.velocity = {speed, 0, 0};
        start.append(sample(b, 400, setup.h, 1, 0));
    }
    t.simulation = make_simulation(setup, std::move(start));
    t.simulation->step(1);
    t.bytes = (resident_bytes() - before) / static_cast<double>(t.simulation->size());
}

void take_steps(Trial& t, int steps) {
    omp_set_num_threads(t.threads);
    for (int i = 0; i < steps; ++i) {
        const StepReport report = t.simulation->step(1);
        t.steps.push_back(report.seconds);
        if (report.iterations > 0) t.iteration.push_back(report.seconds.solve / report.iterations);
    }
}

double sum(const PhaseSeconds& p) { return p.sort + p.scatter + p.grid + p.solve + p.gather; }

// The lower quartile: what the machine does when others leave it alone for a while.
double quartile(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(values.size() / 4);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}
// Of all steps [ns a particle].
template <class F> double quartile_of(const Trial& t, F&& f) {
    std::vector<double> values;
    for (const PhaseSeconds& p : t.steps) values.push_back(1e9 * f(p) / static_cast<double>(t.simulation->size()));
    return quartile(values);
}

// What another program says of itself: "... 1500 ns per particle-step ...".
double run_yardstick(const std::string& program, double particles) {
    const std::string command = fmt::format("{} {:.0f} 5", program, particles);
    std::FILE* pipe = ::popen(command.c_str(), "r");
    std::string text(4096, '\0');
    text.resize(pipe ? std::fread(text.data(), 1, text.size(), pipe) : 0);
    std::smatch found;
    if (!pipe || ::pclose(pipe) != 0 || !std::regex_search(text, found, std::regex("([0-9.]+) ns per particle-step")))
        throw UsageError("--yardstick " + program + ": must be a program that prints \"N ns per particle-step\"");
    return std::stod(found[1]);
}

std::vector<Trial> trials(double n, int threads) {
    Solver explicit_step;
    explicit_step.integrator = Integrator::explicit_euler, explicit_step.weights = Weights::quadratic;
    Solver cubic = explicit_step, apic = explicit_step, twofold = explicit_step, implicit = cubic;
    cubic.weights = implicit.weights = Weights::cubic;
    Solver resting = explicit_step;
    resting.rest_speed = 1e-3, resting.rest_time = 1e-9;
    apic.transfer = Transfer::apic, twofold.precision = Precision::twofold;
    implicit.integrator = Integrator::semi_implicit, implicit.tolerance = 1e-9, implicit.max_iterations = 20;
    std::vector<Trial> all;
    all.push_back({"explicit, quadratic", explicit_step, 1, n});
    all.push_back({"explicit, cubic", cubic, 1, n});
    if (threads > 1) {
        all.push_back({"explicit, quadratic", explicit_step, threads, n});
        all.push_back({"explicit, cubic", cubic, threads, n});
    }
    all.push_back({"APIC", apic, 1, n});
    all.push_back({"double", twofold, 1, n});
    all.push_back({"semi-implicit, cubic", implicit, 1, n});
    all.push_back({"a fourth of the particles", explicit_step, 1, n / 4});
    all.push_back({"four times the particles", explicit_step, 1, 4 * n});
    all.push_back({"8 balls in 100 times the box", explicit_step, 1, n, 8});
    all.push_back({"a tenth of it awake", resting, 1, n / 10, 1, true});
    return all;
}

}  // namespace

int bench_command(const BenchOptions& options) {
    const int threads = omp_get_max_threads();
    std::vector<Trial> all = trials(options.particles, threads);
    std::vector<double> yardstick;
    for (Trial& t : all) set_up(t);
    for (int round = 0; round < options.rounds; ++round) {     // interleaved: a busy machine slows all alike
        if (!options.yardstick.empty()) yardstick.push_back(run_yardstick(options.yardstick, options.particles));
        for (Trial& t : all) take_steps(t, 4);
    }

    const Machine machine = this_machine();
    std::string text = fmt::format("{}, {} cores; float and FLIP where nothing else is said; lower quartiles of {} rounds, "
                                   "ns a particle and step\n\n", machine.cpu, machine.cores, options.rounds);
    text += fmt::format("{:<29} {:>7} {:>9} {:>6} {:>8} {:>6} {:>7} {:>7} {:>7} {:>7}{}\n", "", "threads", "particles", "sort",
                        "scatter", "grid", "solve", "gather", "all", "bytes", yardstick.empty() ? "" : "  × yardstick");
    for (const Trial& t : all) {
        const double ns = quartile_of(t, sum);
        text += fmt::format("{:<29} {:>7} {:>9} {:>6.1f} {:>8.1f} {:>6.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.0f}", t.name, t.threads,
                            t.simulation->size(), quartile_of(t, [](auto& p) { return p.sort; }),
                            quartile_of(t, [](auto& p) { return p.scatter; }), quartile_of(t, [](auto& p) { return p.grid; }),
                            quartile_of(t, [](auto& p) { return p.solve; }), quartile_of(t, [](auto& p) { return p.gather; }), ns, t.bytes);
        text += yardstick.empty() ? "\n" : fmt::format("  {:.1f}\n", quartile(yardstick) / ns);
    }
    const auto find = [&](std::string_view name) -> const Trial& {
        return *std::find_if(all.begin(), all.end(), [&](const Trial& t) { return t.name == name; });
    };
    const double base = quartile_of(all[0], sum), cubic = quartile_of(find("explicit, cubic"), sum);
    const Trial& implicit = find("semi-implicit, cubic");
    text += fmt::format("\nAPIC / FLIP {:.2f}; double / float {:.2f}; all awake / a tenth {:.1f}; one iteration of a solve, its "
                        "share of the setting up included / an explicit step {:.2f}\n", quartile_of(find("APIC"), sum) / base,
                        quartile_of(find("double"), sum) / base, base / quartile_of(find("a tenth of it awake"), sum),
                        1e9 * quartile(implicit.iteration) / static_cast<double>(implicit.simulation->size()) / cubic);
    if (!yardstick.empty()) text += fmt::format("the yardstick: {:.0f} ns\n", quartile(yardstick));
    print_result(text);
    return 0;
}

}  // namespace firn
