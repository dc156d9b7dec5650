#include "problem_file/plant/memory_need.hpp"

#include <algorithm>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "ocp/residuals/residuals.hpp"

namespace conddp {
namespace {

/// Maximum number of rows of a distance between two shapes.
double rows_of_pair(const ProblemSpec& spec) {
  const auto is_plane = [](const auto& body) {
    return std::holds_alternative<HalfSpaceSpec>(body.form);
  };
  const bool half_spaces = std::ranges::any_of(spec.collision.obstacles, is_plane) ||
                           std::ranges::any_of(spec.terrain, is_plane);
  const bool polytopes = std::ranges::any_of(spec.collision.shapes, [](const auto& shape) {
    return !std::holds_alternative<SphereSpec>(shape.form) &&
           !std::holds_alternative<CapsuleSpec>(shape.form);
  });
  return half_spaces && polytopes ? DistancePair::kMostHeights : 2;
}

/// Maximum number of residual rows of a constraint other than a norm.
double rows_of(const ConstraintSpec& constraint, const ProblemSpec& spec, int ndx, int nu) {
  constexpr double kPoseRows = 6, kConeRows = 17;
  const CostSpec& function = constraint.function;
  const ResidualDefinition& definition = *function.definition;
  if (definition.needs.shapes) {
    const double each = rows_of_pair(spec);
    const PairsSpec pairs = function.keys.value(key::pairs);
    if (pairs.choice == PairsSpec::Choice::kNamed)
      return each * static_cast<double>(pairs.named.size());
    const auto shapes = static_cast<double>(spec.collision.shapes.size());
    return each * shapes * (shapes + static_cast<double>(spec.collision.obstacles.size()));
  }
  if (definition.of_contacts()) return kConeRows * static_cast<double>(spec.contacts.size());
  return definition.has(key::frame.name) ? kPoseRows : std::max(ndx, nu);
}

}  // namespace

ConstraintCount count_constraints(const ProblemSpec& spec, int ndx, int nu) {
  ConstraintCount count;
  for (const ConstraintSpec& constraint : spec.constraints) {
    const double each = std::max<double>(1, static_cast<double>(constraint.centers.size()));
    const bool norm = constraint.at_least || constraint.at_most;
    count.constraints += each;
    count.rows += norm ? each : rows_of(constraint, spec, ndx, nu);
  }
  if (!spec.terminal_constraints.empty() || (spec.terminal_lqr && spec.terminal_lqr->set))
    count.constraints = std::max(count.constraints, 1.0);
  return count;
}

double memory_need(double knots, int ndx, int nu, std::size_t costs,
                   const ConstraintCount& constraints) {
  const double z = ndx + nu;
  double numbers = 3.5 * z * z + 60 * z + 100 + static_cast<double>(costs) * (ndx + 4);
  // Newton's method stores additional derivatives.
  if (constraints.constraints > 0) numbers += 6 * z * z + 20 * z;
  numbers += constraints.rows * (3 * z + 25) + 65 * constraints.constraints;
  return knots * numbers * sizeof(double);
}

double memory_there() {
  double bytes = std::numeric_limits<double>::infinity();
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page > 0) bytes = static_cast<double>(pages) * static_cast<double>(page);
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit limit{};
    if (getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
      bytes = std::min(bytes, static_cast<double>(limit.rlim_cur));
  }
  return bytes;
}

void check_memory(const ProblemSpec& spec, int ndx, int nu, Diagnostics& out) {
  double knots = 0;
  const PhaseSpec* longest = &spec.phases.front();
  for (const PhaseSpec& phase : spec.phases) {
    knots += phase.knots.value;
    if (phase.knots.value > longest->knots.value) longest = &phase;
  }
  const double need =
      memory_need(knots, ndx, nu, spec.costs.size(), count_constraints(spec, ndx, nu));
  const double there = memory_there();
  if (need <= there) return;
  out.error(longest->knots.place,
            fmt::format("{:.0f} knots with {} numbers in the state and {} controls need about "
                        "{:.3g} GiB of memory, and there are {:.3g}",
                        knots, ndx, nu, need / kGiB, there / kGiB),
            "take fewer knots");
}

}  // namespace conddp
