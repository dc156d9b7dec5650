#include "problem_file/assemble/loop_swings.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "problem_file/model/named_phases.hpp"
#include "problem_file/motion/footholds.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"

namespace conddp {
namespace {

/// Index of a cost's reference among the parameters of a node; −1 if the node lacks the cost.
int reference_at(const KnotModel& model, const std::string& cost) {
  const auto term = std::ranges::find(model.costs(), cost, &CostTerm::name);
  return term == model.costs().end() ? -1 : term->parameters;
}

void add_swings(const CostSpec& cost, int foot, const ProblemSpec& spec,
                const ShootingProblem& problem, std::vector<FootSwing>& swings) {
  for (const SwingRun& run : swing_runs(phases_named(cost.phases, spec), spec)) {
    FootSwing swing{.foot = foot};
    for (int k = run.first; k <= run.last; ++k) {
      const int reference = reference_at(*problem.knot(k).model, cost.name.value);
      if (reference < 0) continue;
      swing.nodes.push_back(k);
      swing.references.push_back(reference);
    }
    if (swing.nodes.size() > 1) swings.push_back(std::move(swing));
  }
}

/// Computes positions of frames in states, without allocation unless the robot has mimic joints.
std::function<void(const double* x, double* places)> finder(
    std::shared_ptr<const MultibodySystem> system, std::vector<int> frames) {
  const auto data = std::make_shared<RobotData<double>>(system->robot());
  return [system, frames = std::move(frames), data](const double* x, double* places) {
    const RobotModel& robot = system->robot();
    if (robot.mimics.empty()) {
      update_placements(robot, x, *data);
    } else {
      const std::vector<double> q = system->expand_configuration({x, x + system->nq()});
      update_placements(robot, q.data(), *data);
    }
    for (const int frame : frames) {
      const Vector3<double> p = frame_placement(robot, *data, frame).p;
      *places++ = p.x;
      *places++ = p.y;
      *places++ = p.z;
    }
  };
}

}  // namespace

std::optional<FootSwings> build_loop_swings(const ProblemSpec& spec, const BuiltProblem& built,
                                            Diagnostics& out) {
  if (!spec.mpc->measured_swings) return std::nullopt;
  FootSwings all;
  std::vector<int> frames;
  for (const CostSpec& cost : spec.costs) {
    if (cost.keys.find(key::swing) == nullptr) continue;
    const auto frame = find_frame(built.plant.robot(), *cost.keys.find(key::frame), "", out);
    if (!frame) return std::nullopt;
    const auto known = std::ranges::find(frames, *frame);
    const int foot = static_cast<int>(known - frames.begin());
    if (known == frames.end()) frames.push_back(*frame);
    add_swings(cost, foot, spec, *built.problem, all.swings);
  }
  if (all.swings.empty()) {
    out.error(*spec.mpc->measured_swings, "the file has no swings that could begin at the feet",
              "leave the key out");
    return std::nullopt;
  }
  all.feet = static_cast<int>(frames.size());
  all.find_feet = finder(built.plant.multibody(), std::move(frames));
  return all;
}

}  // namespace conddp
