#include "problem_file/terms/swing_reference.hpp"

#include <fmt/format.h>

#include "problem_file/model/named_phases.hpp"
#include "problem_file/motion/swing_arc.hpp"

namespace conddp {
namespace {

/// Number of phases that hold a contact, and the first of them within the swing, if any.
struct Hold {
  std::size_t phases = 0;
  std::optional<std::size_t> in_swing;
};

Hold hold_of(int contact, const std::vector<bool>& swings, const ContactPlan& plan) {
  Hold hold;
  for (std::size_t p = 0; p < swings.size(); ++p) {
    if (!plan.find(p, contact)) continue;
    ++hold.phases;
    if (swings[p] && !hold.in_swing) hold.in_swing = p;
  }
  return hold;
}

/// True if no phase of the swing holds the frame.
bool is_free(const CostSpec& cost, int frame, const std::vector<bool>& swings,
             const ProblemSpec& spec, const ContactPlan& plan, Diagnostics& out) {
  const SwingSpec& swing = *cost.keys.find(key::swing);
  const Name& name = *cost.keys.find(key::frame);
  for (std::size_t c = 0; c < spec.contacts.size(); ++c) {
    if (plan.contacts()[c].frame != frame) continue;
    const Hold hold = hold_of(static_cast<int>(c), swings, plan);
    if (!hold.in_swing) continue;
    const std::string& contact = spec.contacts[c].name.value;
    if (hold.phases == swings.size())
      out.error(swing.place,
                fmt::format("'{}' is asked to swing and never lifts: every phase holds it on the "
                            "ground by the contact '{}'",
                            name.value, contact),
                "take the contact out of the phases in which it swings");
    else
      out.error(swing.place,
                fmt::format("'{}' cannot swing in phase '{}', which holds it on the ground by the "
                            "contact '{}'",
                            name.value, spec.phases[*hold.in_swing].name.value, contact),
                "name the phases of the swing with 'phases', or take the contact out of them");
    return false;
  }
  return true;
}

/// The reference at a share of a swing's duration: a position, or a pose.
std::vector<double> reference_at(const SwingArc& arc, double s, bool turns) {
  const Vector3<double> p = arc.place(s);
  std::vector<double> value{p.x, p.y, p.z};
  if (!turns) return value;
  const Quaternion<double> q = arc.orientation(s);
  value.insert(value.end(), {q.x, q.y, q.z, q.w});
  return value;
}

/// Appends the reference along an arc, node by node.
void append(const SwingArc& arc, const SwingRun& run, bool turns, const std::vector<double>& times,
            TimeSeries& series) {
  const double begin = times[run.first], duration = times[run.last] - begin;
  for (int k = run.first; k <= run.last; ++k) {
    if (k > run.first && times[k] == times[k - 1]) continue;  // an impulse
    const double s = k == run.last ? 1 : (times[k] - begin) / duration;
    series.append(times[k], reference_at(arc, s, turns));
  }
}

}  // namespace

std::optional<TimeSeries> swing_reference(const CostSpec& cost, const CostResidual& residual,
                                          const ProblemSpec& spec, const ContactPlan& plan,
                                          const Plant& plant, const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out) {
  const std::vector<bool> swings = phases_named(cost.phases, spec, out);
  const SwingSpec& swing = *cost.keys.find(key::swing);
  const Name& frame = *cost.keys.find(key::frame);
  if (!is_free(cost, residual.frame, swings, spec, plan, out)) return std::nullopt;
  const std::vector<SwingRun> runs = swing_runs(swings, spec);
  if (runs.empty()) {
    out.error(swing.place, "the swing has no phase");
    return std::nullopt;
  }
  const SE3<double> start = placement_in_state(*plant.multibody(), initial, residual.frame);
  const Foot foot{frame.value, residual.frame, start.p};
  if (!check_landings(cost, foot, runs.size(), spec, plant, initial, out)) return std::nullopt;
  const std::vector<Foothold> places = footholds(foot, spec, plant, initial);
  const Quaternion<double> stance = quaternion(start.R);
  const bool turns = residual.parameters.nx() == pose_manifold().nx();
  const std::vector<Vector3<double>> points = contact_points(frame.value, spec);
  TimeSeries series(residual.parameters);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const SwingRun& run = runs[i];
    if (!(times[run.last] > times[run.first])) {
      out.error(swing.place, "a swing takes time, and an impulse none");
      return std::nullopt;
    }
    SwingArc arc{places.front(), places[run.first_phase], places[run.end_phase], swing.height,
                 stance};
    if (!spec.terrain.empty()) {
      arc.height = clearing_height(arc, points, spec.terrain);
      warn_of_terrain(arc, points, spec.terrain, {frame.value, i + 1, swing.place}, out);
    }
    append(arc, run, turns, times, series);
  }
  return series;
}

}  // namespace conddp
