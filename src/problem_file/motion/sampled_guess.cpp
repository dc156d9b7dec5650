#include "problem_file/motion/sampled_guess.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "analysis/contact/simulated_contacts.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_file/data/time_series.hpp"
#include "problem_file/model/enum_names.hpp"
#include "solvers/sampling/sampling.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// An entry of a knot's control.
struct ControlEntry {
  int knot, control;
  double time;  ///< s
};

/// Entries by the name of their control.
using Channels = std::map<std::string, std::vector<ControlEntry>>;

bool is_choice(const ShootingProblem& problem, int k) {
  return problem.phases()[problem.knot(k).phase].instant;
}

/// Actuators of all knots that take time, and the linear controls that are chosen at the start.
Channels channels_of(const ShootingProblem& problem) {
  Channels channels;
  bool linear = false;
  for (int k = 0; k < problem.knots(); ++k) {
    if (is_choice(problem, k) || problem.nu(k) == 0) continue;
    const KnotModel& model = *problem.knot(k).model;
    linear = model.step().has_linear_controls();
    for (int i = 0; i < model.system().actuators(); ++i)
      channels[model.system().control_columns()[i].name].push_back(
          {k, i, problem.times()[linear ? k + 1 : k]});
  }
  if (!linear || !is_choice(problem, 0)) return channels;
  const std::vector<Column>& columns = problem.knot(0).model->system().control_columns();
  for (int i = 0; i < problem.nu(0); ++i)
    if (const auto found = channels.find(columns[i].name); found != channels.end())
      found->second.push_back({0, i, problem.times()[0]});
  return channels;
}

/// Times at which controls act, s.
std::set<double> times_of(const Channels& channels) {
  std::set<double> times;
  for (const auto& [name, entries] : channels)
    for (const ControlEntry& entry : entries) times.insert(entry.time);
  return times;
}

/// Sizes of controls: half of their range.
class ControlSizes {
 public:
  ControlSizes(const ShootingProblem& problem, const Trajectory& nominal) : problem_(problem) {
    Trajectory simulated = nominal;
    Linearization linearization(problem);
    Evaluator evaluator(problem);
    if (evaluator.simulate(simulated, true) >= 0) return;
    evaluator.differentiate(simulated, linearization);
    cost_ = linearization.total_cost();
    for (int k = 0; k < problem.knots(); ++k)
      curvatures_.emplace_back(linearization.knots[k].hessian().diagonal().tail(problem.nu(k)));
  }

  /// Half of the range between bounds, or between the limits of the URDF; 0 without both.
  double bounded(const ControlEntry& at) const {
    const KnotModel& model = *problem_.knot(at.knot).model;
    const double range = model.control_upper()[at.control] - model.control_lower()[at.control];
    if (std::isfinite(range)) return range / 2;
    const System& system = model.system();
    if (at.control >= static_cast<int>(system.control_upper().size())) return 0;
    const double limit = system.control_upper()[at.control] - system.control_lower()[at.control];
    return std::isfinite(limit) ? limit / 2 : 0;
  }

  /// Half of the range of a channel. Without bounds and limits, a constant change of this size
  /// costs as much as the whole motion by its control cost alone: larger ones can gain nothing.
  /// Without a control cost, 1 in the control's unit.
  double size(const std::vector<ControlEntry>& entries) const {
    double largest = 0, curvature = 0;
    for (const ControlEntry& entry : entries) {
      largest = std::max(largest, bounded(entry));
      if (!curvatures_.empty()) curvature += curvatures_[entry.knot][entry.control];
    }
    if (largest > 0) return largest;
    const double size = std::sqrt(2 * cost_ / curvature);
    return std::isfinite(size) && size > 0 ? size : 1;
  }

 private:
  const ShootingProblem& problem_;
  double cost_ = 0;
  std::vector<Eigen::VectorXd> curvatures_;  ///< ∂²ℓ/∂u² by knot; empty if not finite
};

ControlSplines splines_of(const ShootingProblem& problem, const Trajectory& nominal,
                          const Channels& channels, const GuessSpec::Sampling& sampling) {
  const std::set<double> times = times_of(channels);
  const ControlSizes sizes(problem, nominal);
  ControlSplines splines(problem, nominal);
  if (!times.empty()) {
    const TimeSeries units =
        unit_splines(sampling.knots.value, sampling.spline, *times.begin(), *times.rbegin());
    for (const auto& [name, entries] : channels) {
      const int channel = splines.add_channel(sampling.knots.value, sizes.size(entries));
      for (const ControlEntry& entry : entries)
        splines.add_entry(entry.knot, entry.control, channel, units.interpolate(entry.time));
    }
  }
  if (!is_choice(problem, 0)) return splines;
  constexpr double kOne[] = {1};
  for (int i = 0; i < problem.nu(0); ++i)
    if (const double size = sizes.bounded({0, i, 0}); size > 0)
      splines.add_entry(0, i, splines.add_channel(1, size), kOne);
  return splines;
}

std::string_view word_of_method(SamplingMethod method) {
  for (const auto& choice : kSamplingWords)
    if (choice.value == method) return choice.word;
  return {};
}

}  // namespace

TimeSeries unit_splines(int nodes, Interpolation interpolation, double first, double last) {
  TimeSeries series(StateManifold::flat(nodes));
  for (int j = 0; j < nodes; ++j) {
    std::vector<double> unit(nodes, 0.0);
    unit[j] = 1;
    series.append(nodes == 1 ? first : std::lerp(first, last, static_cast<double>(j) / (nodes - 1)),
                  std::move(unit));
  }
  if (nodes > 1 && interpolation == Interpolation::kCubic) series.make_cubic();
  return series;
}

bool sample_guess(const ProblemSpec& spec, const Plant& plant, const ShootingProblem& problem,
                  Trajectory& guess, std::string& states, std::string& controls, Diagnostics& out) {
  const GuessSpec::Sampling& sampling = *spec.guess.sampling;
  const Channels channels = channels_of(problem);
  const int times = static_cast<int>(times_of(channels).size());
  if (sampling.knots.value > times && times > 0) {
    out.error(sampling.knots.place,
              fmt::format("splines with {} 'knots' have more nodes than the {} knots with controls",
                          sampling.knots.value, times));
    return false;
  }
  Simulate simulate;
  if (plant.stepping())
    simulate = [&problem](Trajectory& trajectory) {
      auto simulated = simulated_guess(problem, trajectory);
      if (simulated) trajectory = *std::move(simulated);
      return simulated.has_value();
    };
  const Trajectory nominal = guess;
  SampledTrajectory best = search_controls(splines_of(problem, nominal, channels, sampling),
                                           {.method = sampling.method,
                                            .samples = sampling.samples,
                                            .rounds = sampling.rounds,
                                            .seed = sampling.seed,
                                            .threads = spec.solver.options.threads},
                                           simulate);
  if (!best.found) {
    controls += fmt::format("; none of {} rollouts around them is better ({} not finite)",
                            best.rollouts, best.discarded);
    return true;
  }
  states = "those of the best rollout";
  controls += fmt::format(
      "; around them the best of {} rollouts by '{}' with seed {}, cost {:.6g}, violation {:.3g}",
      best.rollouts, word_of_method(sampling.method), sampling.seed, best.value.cost,
      best.value.violation);
  if (best.discarded > 0) controls += fmt::format(" ({} not finite)", best.discarded);
  guess = std::move(best.trajectory);
  return true;
}

}  // namespace conddp
