#include "mpc/window_count.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "mpc/window.hpp"

namespace conddp {
namespace {

/// Common structure of windows: the model of each knot, whether it takes no time, and whether the
/// time line's terminal node applies.
using Structure = std::pair<std::vector<std::pair<const KnotModel*, bool>>, bool>;

Structure structure_of(const WindowCut& cut, const ShootingProblem& problem) {
  Structure structure{{}, cut.has_terminal};
  for (const TimedKnot& part : cut.knots)
    structure.first.emplace_back(problem.knot(part.knot).model, problem.takes_no_time(part.knot));
  return structure;
}

}  // namespace

WindowCount count_windows(std::shared_ptr<const ShootingProblem> problem, const MpcOptions& options,
                          double duration) {
  const TimeLine line(std::move(problem), options.hold);
  const WindowContext context{
      line, options.horizon, nullptr, options.solver, options.solver_options, 1, nullptr};
  std::set<Structure> structures;
  WindowCount count;
  WindowCut cut;
  for (int tick = 0; is_before(tick * options.tick, duration); ++tick) {
    cut_window(context, tick * options.tick + options.delay, cut);
    if (cut.knots.empty()) break;
    structures.insert(structure_of(cut, line.problem()));
    count.knots = std::max(count.knots, static_cast<int>(cut.knots.size()));
  }
  count.structures = static_cast<int>(structures.size());
  return count;
}

}  // namespace conddp
