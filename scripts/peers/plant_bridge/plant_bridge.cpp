// Controls a plant that another process simulates: reads its state line by line, a line each step of
// the plant, and answers with the controls that hold until the next one.
//
// usage: plant_bridge FILE HORIZON TICK FEEDBACK_RATE STEP [KEY=VALUE...]     s, s, Hz, s
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "conddp/files.hpp"
#include "conddp/mpc.hpp"

using namespace conddp;

namespace {

/// False where the input ends.
bool read_state(std::vector<double>& x) {
  for (double& number : x)
    if (!(std::cin >> number)) return false;
  return true;
}

void write_controls(const Eigen::VectorXd& u) {
  for (Eigen::Index i = 0; i < u.size(); ++i) std::printf(i == 0 ? "%.17g" : " %.17g", u[i]);
  std::printf("\n");
  std::fflush(stdout);
}

void control(Mpc& mpc, double step, std::vector<double> x) {
  for (int i = 0;; ++i) {
    const double time = i * step;
    const bool ticks = time > mpc.time() - step / 2;
    if (ticks) mpc.prepare();
    if (!read_state(x)) return;
    write_controls(ticks ? mpc.feedback(x) : mpc.control(time, x.data()));
  }
}

}  // namespace

int main(int count, char** words) {
  if (count < 6) return 2;
  Diagnostics messages;
  const auto spec = read_problem(words[1], {words + 6, words + count}, messages);
  const auto built = spec ? build_problem(*spec, {}, messages) : std::nullopt;
  if (!built) {
    std::fputs(format_diagnostics(messages, false).c_str(), stderr);
    return 2;
  }
  Mpc mpc(built->problem, built->guess,
          {.horizon = std::atof(words[2]),
           .tick = std::atof(words[3]),
           .feedback_rate = std::atof(words[4]),
           .solver = spec->solver.name.value,
           .solver_options = spec->solver.options});
  control(mpc, std::atof(words[5]), built->problem->initial_state());
}
