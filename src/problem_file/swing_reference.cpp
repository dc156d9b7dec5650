#include "problem_file/swing_reference.hpp"

#include <fmt/format.h>

#include "problem_file/footholds.hpp"
#include "problem_file/phase_builder.hpp"

namespace conddp {
namespace {

/// Whether no phase of the swing holds the frame.
bool is_free(const CostSpec& cost, int frame, const std::vector<bool>& swings,
             const ProblemSpec& spec, const ContactPlan& plan, Diagnostics& out) {
  for (std::size_t p = 0; p < swings.size(); ++p) {
    if (!swings[p]) continue;
    for (std::size_t c = 0; c < spec.contacts.size(); ++c)
      if (plan.contacts()[c].frame == frame && plan.find(p, static_cast<int>(c))) {
        out.error(
            cost.swing->place,
            fmt::format("'{}' cannot swing in phase '{}', which holds it on the ground by the "
                        "contact '{}'",
                        cost.frame->value, spec.phases[p].name.value, spec.contacts[c].name.value),
            "name the phases of the swing with 'phases', or take the contact out of them");
        return false;
      }
  }
  return true;
}

}  // namespace

std::optional<TimeSeries> swing_reference(const CostSpec& cost, int frame, const ProblemSpec& spec,
                                          const ContactPlan& plan, const Plant& plant,
                                          const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out) {
  const std::vector<bool> swings = phases_named(cost.phases, spec, out);
  if (!is_free(cost, frame, swings, spec, plan, out)) return std::nullopt;
  TimeSeries series(StateManifold::flat(3));
  const std::vector<Vector3<double>> places =
      footholds(cost.frame->value, placement_in_state(*plant.multibody, initial, frame).p, spec);
  int first = 0;
  for (std::size_t p = 0; p < swings.size();) {
    int knots = 0;
    std::size_t end = p;
    while (end < swings.size() && swings[end] == swings[p]) knots += spec.phases[end++].knots.value;
    if (swings[p]) {
      const Vector3<double>& from = places[p];
      const Vector3<double> to = landing_place(*cost.swing, from);
      if (!(times[first + knots] > times[first])) {
        out.error(cost.swing->place, "a swing takes time, and an impulse none");
        return std::nullopt;
      }
      const double begin = times[first], duration = times[first + knots] - begin;
      for (int k = 0; k <= knots; ++k) {
        if (k > 0 && times[first + k] == times[first + k - 1]) continue;  // an impulse
        const double s = k == knots ? 1 : (times[first + k] - begin) / duration;
        const double along = s * s * (3 - 2 * s);
        series.append(times[first + k],
                      {from.x + along * (to.x - from.x), from.y + along * (to.y - from.y),
                       from.z + along * (to.z - from.z) +
                           16 * cost.swing->height * s * s * (1 - s) * (1 - s)});
      }
    }
    first += knots;
    p = end;
  }
  if (series.empty()) {
    out.error(cost.swing->place, "the swing has no phase");
    return std::nullopt;
  }
  return series;
}

}  // namespace conddp
