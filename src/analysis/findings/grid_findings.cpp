#include "analysis/findings/grid_findings.hpp"

#include <algorithm>
#include <set>
#include <string>

#include <fmt/format.h>

#include "analysis/certificate/coarse_grid.hpp"
#include "analysis/findings/contact_findings.hpp"
#include "analysis/findings/long_step.hpp"
#include "analysis/findings/singular_rate.hpp"
#include "systems/multibody/multibody.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

std::string_view rule_at(const ShootingProblem& problem, int knot) {
  return info_of(problem.knot(knot).model->integrator()).name;
}

/// Errors above this share are not told apart.
constexpr double kMostTold = 10;

std::string percent(double share) {
  if (!(share < kMostTold)) return "over 1000 %";
  return fmt::format("{} %", share < 0.1 ? fmt::format("{:.2g}", 100 * share)
                                         : fmt::format("{:.0f}", 100 * share));
}

/// Other rules and shorter steps with their errors at this motion: those that resolve it, or all of
/// them if none does.
std::string remedy_of(const ShootingProblem& problem, const Trajectory& trajectory,
                      const GridError& found) {
  constexpr int kParts = 4;
  const Integrator own = problem.knot(found.knot).model->integrator();
  std::string good, all;
  const auto test = [&](std::optional<Integrator> rule, int parts, const std::string& name) {
    if (rule == own) return;
    const auto error = error_by(problem, trajectory, found, rule, parts);
    if (!error) return;
    const std::string text = fmt::format("{} ({})", name, percent(*error));
    if (*error <= kCoarse) good += (good.empty() ? "" : " or ") + text;
    all += (all.empty() ? "" : ", ") + text;
  };
  const auto test_rule = [&](Integrator rule) {
    test(rule, 1, fmt::format("'integrator: {}'", info_of(rule).name));
  };
  test_rule(Integrator::rk4);
  test(std::nullopt, kParts, fmt::format("steps of dt/{}", kParts));
  // Implicit steps take much longer than those of the other two together.
  if (good.empty() && allows_collocation(problem)) test_rule(Integrator::radau5);
  if (good.empty()) return fmt::format("'mesh', or still shorter steps: {} are not enough", all);
  return good + ", by the error at this motion";
}

/// True if a contact closes where a knot begins, and no impulse stops it.
bool touches_down(const ShootingProblem& problem, int knot) {
  if (knot == 0 || problem.takes_no_time(knot - 1)) return false;
  const auto contacts_at = [&](int k) {
    const MultibodySystem* robot = problem.knot(k).model->system().robot_inside();
    std::set<std::string> names;
    if (robot != nullptr)
      for (const Contact& contact : robot->contacts().contacts()) names.insert(contact.name);
    return names;
  };
  return !std::ranges::includes(contacts_at(knot - 1), contacts_at(knot));
}

Finding finding_of(FindingKind kind, const ShootingProblem& problem, const Trajectory& trajectory,
                   int knot) {
  Finding f;
  f.kind = kind;
  f.unit = "1";
  f.knot = knot;
  f.time = problem.times(trajectory)[knot];
  return f;
}

}  // namespace

void find_in_grid(const ShootingProblem& problem, const Trajectory& trajectory,
                  const std::vector<Eigen::MatrixXd>& gains, std::vector<Finding>& list) {
  if (const auto step = long_step(problem, trajectory)) {
    Finding f = finding_of(FindingKind::unstable_steps, problem, trajectory, step->knot);
    f.subject = rule_at(problem, step->knot);
    f.value = step->growth;
    f.message = fmt::format(
        "the system is stiff for steps of {}: a motion of the rate {:.3g} 1/s, which does not grow "
        "in time, is multiplied by {:.3g} in a step of {:.3g} s",
        f.subject, step->rate, step->growth, step->step);
    f.remedy = remedy_of(*step, problem);
    list.push_back(std::move(f));
  }
  const auto error = coarse_grid(problem, trajectory, gains);
  // The grid is not to blame for equations without a value.
  if (error && !singular_rate(problem, trajectory, error->knot)) {
    const Column column = tangent_columns(problem.terminal().model->system())[error->entry];
    Finding f = finding_of(FindingKind::coarse_grid, problem, trajectory, error->knot);
    f.subject = column.name;
    f.value = error->relative < kMostTold ? error->relative : kMostTold;
    f.message = fmt::format(
        "the grid does not resolve the motion: the errors of steps of {} add up to {:.2g} {} in "
        "{}, {} of its range",
        rule_at(problem, error->knot), error->sum, column.unit, column.name,
        percent(error->relative));
    f.remedy = remedy_of(problem, trajectory, *error);
    if (touches_down(problem, error->knot))
      f.remedy = fmt::format("{} at each touch-down, and then {}", kImpulseRemedy, f.remedy);
    list.push_back(std::move(f));
  }
}

}  // namespace conddp
