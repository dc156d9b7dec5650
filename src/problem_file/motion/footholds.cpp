#include "problem_file/motion/footholds.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/model/named_phases.hpp"
#include "problem_file/motion/planar_motion.hpp"

namespace conddp {
namespace {

/// The cosine of about 84 degrees.
constexpr double kSteepest = 0.1;

bool is_swing_of(const CostSpec& cost, const std::string& frame) {
  const Name* name = cost.keys.find(key::frame);
  return cost.keys.find(key::swing) != nullptr && name != nullptr && name->value == frame;
}

/// The normal of the ground under a frame, in the world.
Vector3<double> ground_normal(const std::string& frame, const ProblemSpec& spec) {
  for (const ContactSpec& contact : spec.contacts)
    if (contact.frame.value == frame && contact.axes == FrameAxes::world_aligned)
      return contact.normal;
  return {0, 0, 1};
}

/// Landing of a foot that moves with the base from the initial state, on the ground's plane.
std::optional<Vector3<double>> displaced_landing(const Foot& foot, const PlanarMotion& motion,
                                                 const ProblemSpec& spec, const Plant& plant,
                                                 const std::vector<double>& initial) {
  const int joint = plant.robot().frames[foot.frame].joint;
  if (joint < 0) return std::nullopt;
  auto p = displaced_point(plant, part_of(plant, joint), motion, initial, foot.start);
  const Vector3<double> normal = ground_normal(foot.name, spec);
  if (!p || normal.z < kSteepest) return std::nullopt;
  p->z -= (normal.x * (p->x - foot.start.x) + normal.y * (p->y - foot.start.y)) / normal.z;
  return p;
}

/// A swing and its runs, in the order of time.
struct Swing {
  const SwingSpec* spec;
  std::vector<SwingRun> runs;
};

}  // namespace

std::vector<SwingRun> swing_runs(const std::vector<bool>& chosen, const ProblemSpec& spec) {
  std::vector<SwingRun> runs;
  int knot = 0;
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    const int end = knot + spec.phases[p].knots.value;
    if (chosen[p] && (p == 0 || !chosen[p - 1])) runs.push_back({p, p + 1, knot, end});
    if (chosen[p]) {
      runs.back().end_phase = p + 1;
      runs.back().last = end;
    }
    knot = end;
  }
  return runs;
}

bool swings(const std::string& frame, const ProblemSpec& spec) {
  return std::any_of(spec.costs.begin(), spec.costs.end(),
                     [&](const CostSpec& cost) { return is_swing_of(cost, frame); });
}

namespace {

/// The swings of a foot.
std::vector<Swing> swings_of(const Foot& foot, const ProblemSpec& spec) {
  std::vector<Swing> all;
  for (const CostSpec& cost : spec.costs)
    if (is_swing_of(cost, foot.name))
      all.push_back(
          {cost.keys.find(key::swing), swing_runs(phases_named(cost.phases, spec), spec)});
  return all;
}

/// Landing of a swing from `from` in a run; empty if the swing does not define it.
std::optional<Foothold> landing_of(const SwingSpec& swing, std::size_t run, const Foothold& from,
                                   const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                   const std::vector<double>& initial) {
  if (swing.displaced.empty())
    return Foothold{swing.landing.value_or(from.p + swing.step.value_or(Vector3<double>::zero())),
                    from.yaw};
  if (run >= swing.displaced.size()) return std::nullopt;
  const PlanarMotion& motion = swing.displaced[run];
  const auto to = displaced_landing(foot, motion, spec, plant, initial);
  if (!to) return std::nullopt;
  return Foothold{*to, motion.yaw};
}

}  // namespace

std::vector<Foothold> footholds(const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                const std::vector<double>& initial) {
  const std::vector<Swing> all = swings_of(foot, spec);
  const std::size_t n = spec.phases.size();
  std::vector<Foothold> places(n + 1, {foot.start});
  for (std::size_t p = 1; p <= n; ++p) {
    places[p] = places[p - 1];
    for (const auto& [swing, runs] : all)
      for (std::size_t i = 0; i < runs.size(); ++i) {
        if (runs[i].end_phase != p) continue;
        const Foothold& from = places[runs[i].first_phase];
        places[p] = landing_of(*swing, i, from, foot, spec, plant, initial).value_or(places[p]);
      }
  }
  return places;
}

bool check_landings(const CostSpec& cost, const Foot& foot, std::size_t runs,
                    const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                    Diagnostics& out) {
  const SwingSpec& swing = *cost.keys.find(key::swing);
  if (swing.displaced.empty()) return true;
  if (swing.displaced.size() != runs) {
    out.error(swing.place,
              fmt::format("'{}' swings {} {}, and 'displaced' has {} {}", foot.name, runs,
                          runs == 1 ? "time" : "times", swing.displaced.size(),
                          swing.displaced.size() == 1 ? "landing" : "landings"),
              "give one '[x, y, yaw]' for every run of consecutive phases of the cost");
    return false;
  }
  if (ground_normal(foot.name, spec).z < kSteepest) {
    out.error(swing.place,
              fmt::format("the ground under '{}' is too steep for a landing that is displaced in "
                          "the horizontal plane",
                          foot.name),
              "give 'landing' or 'step'");
    return false;
  }
  if (!displaced_landing(foot, swing.displaced.front(), spec, plant, initial)) {
    out.error(swing.place, "the robot's base is fixed: a landing cannot be displaced with it",
              "write 'base: floating' under 'robot', or give the swing a 'landing' or 'step'");
    return false;
  }
  return true;
}

}  // namespace conddp
