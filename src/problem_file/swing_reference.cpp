#include "problem_file/swing_reference.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem_file/phase_builder.hpp"
#include "problem_file/planar_motion.hpp"

namespace conddp {
namespace {

/// The contact of a frame in the file, −1 if it has none.
int contact_of(int frame, const ContactPlan& plan) {
  const auto& contacts = plan.contacts();
  const auto found = std::find_if(contacts.begin(), contacts.end(),
                                  [&](const Contact& c) { return c.frame == frame; });
  return found == contacts.end() ? -1 : static_cast<int>(found - contacts.begin());
}

/// Whether no phase of the swing holds the frame.
bool is_free(const CostSpec& cost, int frame, const std::vector<bool>& swings,
             const ProblemSpec& spec, const ContactPlan& plan, Diagnostics& out) {
  for (std::size_t c = 0; c < spec.contacts.size(); ++c) {
    if (plan.contacts()[c].frame != frame) continue;
    std::size_t held = 0, asked = swings.size();
    for (std::size_t p = swings.size(); p-- > 0;) {
      if (!plan.find(p, static_cast<int>(c))) continue;
      ++held;
      if (swings[p]) asked = p;
    }
    if (asked == swings.size()) continue;
    if (held == swings.size())
      out.error(cost.swing->place,
                fmt::format("'{}' is asked to swing and never lifts: every phase holds it on the "
                            "ground by the contact '{}'",
                            cost.frame->value, spec.contacts[c].name.value),
                "take the contact out of the phases in which it swings");
    else
      out.error(cost.swing->place,
                fmt::format("'{}' cannot swing in phase '{}', which holds it on the ground by the "
                            "contact '{}'",
                            cost.frame->value, spec.phases[asked].name.value,
                            spec.contacts[c].name.value),
                "name the phases of the swing with 'phases', or take the contact out of them");
    return false;
  }
  return true;
}

/// A run of phases in which a frame swings, by its first and last node.
struct Run {
  int first, last;
};

std::vector<Run> runs_of(const std::vector<bool>& swings, const ProblemSpec& spec) {
  std::vector<Run> runs;
  int knot = 0;
  for (std::size_t p = 0; p < swings.size(); ++p) {
    const int end = knot + spec.phases[p].knots.value;
    if (swings[p] && p > 0 && swings[p - 1])
      runs.back().last = end;
    else if (swings[p])
      runs.push_back({knot, end});
    knot = end;
  }
  return runs;
}

/// Where a frame stands: a point, and how far it is turned about the vertical.
struct Foothold {
  Vector3<double> p;
  double yaw = 0;
};

/// Where the frame lands after each run.
std::optional<std::vector<Foothold>> landings(const CostSpec& cost, int frame,
                                              const Vector3<double>& start, std::size_t runs,
                                              const ContactPlan& plan, const Plant& plant,
                                              const std::vector<double>& initial,
                                              Diagnostics& out) {
  const SwingSpec& swing = *cost.swing;
  std::vector<Foothold> result;
  if (swing.displaced.empty()) {
    Vector3<double> p = start;
    for (std::size_t i = 0; i < runs; ++i) {
      p = swing.landing.value_or(p + swing.step.value_or(Vector3<double>::zero()));
      result.push_back({p});
    }
    return result;
  }
  if (swing.displaced.size() != runs) {
    out.error(swing.place,
              fmt::format("'{}' swings {} {}, and 'displaced' has {} {}", cost.frame->value, runs,
                          runs == 1 ? "time" : "times", swing.displaced.size(),
                          swing.displaced.size() == 1 ? "landing" : "landings"),
              "give one '[x, y, yaw]' for every run of consecutive phases of the cost");
    return std::nullopt;
  }
  Vector3<double> normal{0, 0, 1};
  if (const int c = contact_of(frame, plan); c >= 0)
    if (plan.contacts()[c].axes == FrameAxes::world_aligned) normal = plan.contacts()[c].normal;
  constexpr double kSteepest = 0.1;  // the cosine of about 84 degrees
  if (normal.z < kSteepest) {
    out.error(swing.place,
              fmt::format("the ground under '{}' is too steep for a landing that is "
                          "displaced in the horizontal plane",
                          cost.frame->value),
              "give 'landing' or 'step'");
    return std::nullopt;
  }
  const int joint = plant.robot().frames[frame].joint;
  for (const PlanarMotion& motion : swing.displaced) {
    std::optional<Vector3<double>> p;
    if (joint >= 0) p = displaced_point(plant, part_of(plant, joint), motion, initial, start);
    if (!p) {
      out.error(swing.place, "the robot's base is fixed: a landing cannot be displaced with it",
                "write 'base: floating' under 'robot', or give the swing a 'landing' or 'step'");
      return std::nullopt;
    }
    p->z -= (normal.x * (p->x - start.x) + normal.y * (p->y - start.y)) / normal.z;
    result.push_back({*p, motion.yaw});
  }
  return result;
}

}  // namespace

std::optional<TimeSeries> swing_reference(const CostSpec& cost, const CostResidual& residual,
                                          const ProblemSpec& spec, const ContactPlan& plan,
                                          const Plant& plant, const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out) {
  const std::vector<bool> swings = phases_named(cost.phases, spec, out);
  if (!is_free(cost, residual.frame, swings, spec, plan, out)) return std::nullopt;
  const std::vector<Run> runs = runs_of(swings, spec);
  if (runs.empty()) {
    out.error(cost.swing->place, "the swing has no phase");
    return std::nullopt;
  }
  const SE3<double> start = placement_in_state(*plant.multibody, initial, residual.frame);
  const auto lands =
      landings(cost, residual.frame, start.p, runs.size(), plan, plant, initial, out);
  if (!lands) return std::nullopt;
  const Quaternion<double> stance = quaternion(start.R);
  TimeSeries series(residual.parameters);
  Foothold from{start.p};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Foothold& to = (*lands)[i];
    const double begin = times[runs[i].first], duration = times[runs[i].last] - begin;
    for (int k = runs[i].first; k <= runs[i].last; ++k) {
      const double s = duration > 0 ? (times[k] - begin) / duration : 1;
      const double along = s * s * (3 - 2 * s);
      const double above = 16 * cost.swing->height * s * s * (1 - s) * (1 - s);
      std::vector<double> value{from.p.x + along * (to.p.x - from.p.x),
                                from.p.y + along * (to.p.y - from.p.y),
                                from.p.z + along * (to.p.z - from.p.z) + above};
      if (cost.kind == ResidualKind::kFramePlacement) {
        const double half = (from.yaw + along * (to.yaw - from.yaw)) / 2;
        const Quaternion<double> q =
            Quaternion<double>{0, 0, std::sin(half), std::cos(half)} * stance;
        value.insert(value.end(), {q.x, q.y, q.z, q.w});
      }
      series.append(times[k], std::move(value));
    }
    from = to;
  }
  return series;
}

}  // namespace conddp
