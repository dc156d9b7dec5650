#include "problem_file/lower/gait.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "problem_file/lower/gait_rise.hpp"
#include "problem_file/motion/planar_motion.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

/// A foot's swings in knots: the n-th swing begins at first + n·period.
struct FootSteps {
  int first = 0;
  double start = 0;
};

/// A section of the path with uniform motion of the base.
struct WayPart {
  double from;          ///< position in the path, cycles
  PlanarMotion before;  ///< motion up to its beginning
  PlanarMotion step;    ///< motion per cycle
};

class GaitSchedule {
 public:
  GaitSchedule(const GaitSpec& gait, ProblemSpec& spec, Diagnostics& out)
      : gait_(gait), spec_(spec), out_(out), before_(static_cast<int>(spec.phases.size())) {}

  void add() {
    const int errors = out_.error_count();
    count_knots();
    if (out_.error_count() > errors) return;
    make_phases();
    if (before_ > 0) spec_.phases[0].contacts = spec_.phases[before_].contacts;
    make_way();
    if (swings()) make_costs();
    if (swings() && !spec_.terrain.empty()) rise_ = GaitRise(paths_of_feet(), spec_);
    for (const auto& [knot, share] : way()) spec_.gait_way.push_back({node(knot), base(share)});
    for (CostSpec& cost : spec_.costs) lead(cost, false);
    for (CostSpec& cost : spec_.terminal_costs) lead(cost, true);
  }

 private:
  bool swings() const { return gait_.type.value != GaitType::stand; }
  int cycles() const { return swings() ? gait_.cycles : 0; }
  int foot_count() const { return static_cast<int>(gait_.feet.size()); }
  int lift_off(int foot, int cycle) const { return feet_[foot].first + cycle * period_; }
  int touch_down(int foot, int cycle) const { return lift_off(foot, cycle) + swing_; }

  /// A duration in knots, which must be a whole number.
  int knots_of(const Located<double>& duration, std::string_view what) {
    const double steps = duration.value / gait_.dt.value;
    constexpr double kRounding = 1e-6;
    if (!(steps <= kMaxKnots)) {
      out_.error(duration.place, fmt::format("{} {} s is more than {} steps of dt {} s", what,
                                             duration.value, kMaxKnots, gait_.dt.value));
      return 1;
    }
    if (std::abs(steps - std::round(steps)) > kRounding)
      out_.error(duration.place,
                 fmt::format("{} {} s is {:.6g} times dt, {} s: it must be a whole number of steps",
                             what, duration.value, steps, gait_.dt.value));
    return static_cast<int>(std::lround(steps));
  }

  void count_knots() {
    const int errors = out_.error_count();
    begin_ = knots_of(gait_.begin, "standing before the gait");
    const int stand = knots_of(gait_.end, "standing after the gait");
    if (swings()) {
      period_ = knots_of(gait_.period, "the period");
      if (out_.error_count() > errors) return;
      set_swing(stand);
      if (out_.error_count() > errors) return;
    }
    const double total =
        static_cast<double>(begin_) + stand + static_cast<double>(cycles()) * period_;
    if (total > kMaxKnots)
      return out_.error(gait_.place, fmt::format("the gait has more than {} knots", kMaxKnots));
    if (total < 1) return out_.error(gait_.place, "the gait takes no time");
    set_feet();
    end_ = begin_ + stand;
    for (int foot = 0; swings() && foot < foot_count(); ++foot)
      end_ = std::max(end_, touch_down(foot, cycles() - 1) + stand);
  }

  /// Sets the swing duration: a part of the period, which must leave time to stand at the end.
  void set_swing(int stand) {
    swing_ = static_cast<int>(std::lround((1 - gait_.duty.value) * period_));
    if (swing_ < 1)
      return out_.error(gait_.duty.place,
                        fmt::format("with a duty of {} no foot ever lifts: it would be in the air "
                                    "for {:.3g} s of the period, less than one step of dt {} s",
                                    gait_.duty.value, (1 - gait_.duty.value) * gait_.period.value,
                                    gait_.dt.value),
                        "lower 'duty', the share of the cycle that a foot stands");
    if (swing_ >= period_)
      return out_.error(
          gait_.duty.place,
          fmt::format("with a duty of {} no foot ever stands: that would be for "
                      "{:.3g} s of the period, less than one step of dt {} s",
                      gait_.duty.value, gait_.duty.value * gait_.period.value, gait_.dt.value));
    if (stand < 1)
      out_.error(gait_.end.place,
                 "the feet touch down at the beginning of the stand at the end: it needs "
                 "one step at least",
                 "raise 'stand: {end: ...}'");
  }

  void set_feet() {
    earliest_ = 1, latest_ = 0;
    for (const FootSpec& foot : gait_.feet) {
      feet_.push_back({knot_of_start(foot.start), foot.start});
      earliest_ = std::min(earliest_, foot.start);
      latest_ = std::max(latest_, foot.start);
    }
  }

  /// The first knot of a foot's first cycle.
  int knot_of_start(double start) const {
    return begin_ + static_cast<int>(std::lround(start * period_));
  }

  bool stands(int foot, int knot) const {
    if (!swings() || knot < feet_[foot].first) return true;
    const int since = knot - feet_[foot].first;
    return since / period_ >= cycles() || since % period_ >= swing_;
  }

  std::vector<Name> standing(int knot) const {
    std::vector<Name> names;
    for (int foot = 0; foot < foot_count(); ++foot)
      if (stands(foot, knot)) names.push_back(gait_.feet[foot].contact);
    return names;
  }

  std::string phase_name(int knot, const std::vector<Name>& held) const {
    const int count = static_cast<int>(held.size());
    const int index = static_cast<int>(spec_.phases.size()) - before_ + 1;
    if (count == 0) return fmt::format("flight_{}", index);
    if (count == foot_count()) return fmt::format("stand_{}", index);
    std::string name = fmt::format("swing_{}", index);
    for (int foot = 0; foot < foot_count(); ++foot)
      if (!stands(foot, knot)) name += "_" + gait_.feet[foot].contact.value;
    return name;
  }

  /// Place of the key that determines a phase's length.
  const Place& place_of_length(bool first, bool last) const {
    const Place& key = first ? gait_.begin.place : last ? gait_.end.place : gait_.period.place;
    return key;
  }

  void make_phases() {
    std::set<int> changes = {0};
    for (int foot = 0; foot < foot_count(); ++foot)
      for (int cycle = 0; cycle < cycles(); ++cycle) {
        changes.insert(lift_off(foot, cycle));
        changes.insert(touch_down(foot, cycle));
      }
    swing_phases_.resize(foot_count());
    for (auto change = changes.begin(); change != changes.end(); ++change) {
      const int from = *change;
      const int to = std::next(change) == changes.end() ? end_ : *std::next(change);
      if (from > 0 && gait_.impulses) add_impulse(from);
      const std::vector<Name> held = standing(from);
      add_phase({.name = {phase_name(from, held), gait_.place},
                 .knots = {to - from, place_of_length(from == 0, to == end_)},
                 .dt = gait_.dt.value,
                 .free_duration = free_duration((to - from) * gait_.dt.value),
                 .contacts = {.names = held}},
                from, from);
    }
  }

  std::optional<FreeDurationSpec> free_duration(double duration) const {
    if (!gait_.free_durations) return std::nullopt;
    const auto& [place, lower, upper] = *gait_.free_durations;
    return FreeDurationSpec{place, lower * duration, upper * duration};
  }

  /// Appends a phase. Feet in the air before and after it swing in it.
  void add_phase(PhaseSpec phase, int before, int after) {
    for (int foot = 0; foot < foot_count(); ++foot)
      if (!stands(foot, before) && !stands(foot, after)) swing_phases_[foot].push_back(phase.name);
    spec_.phases.push_back(std::move(phase));
  }

  /// Adds the impulse of the feet that touch down at a knot, including feet already in stance.
  void add_impulse(int knot) {
    std::string name = fmt::format("touch_down_{}", spec_.phases.size() - before_ + 1);
    bool touches = false;
    for (int foot = 0; foot < foot_count(); ++foot)
      if (stands(foot, knot) && !stands(foot, knot - 1)) {
        name += "_" + gait_.feet[foot].contact.value;
        touches = true;
      }
    if (!touches) return;
    impulses_.push_back(knot);
    add_phase({.name = {name, gait_.place},
               .knots = {1, gait_.place},
               .contacts = {.names = standing(knot)},
               .restitution = 0},
              knot - 1, knot);
  }

  /// Builds the path from the step lengths, and after each command from its velocity.
  void make_way() {
    way_ = {{0,
             {},
             {gait_.step_length * std::cos(gait_.direction),
              gait_.step_length * std::sin(gait_.direction), gait_.turn}}};
    for (const GaitCommand& command : gait_.commands) {
      const WayPart& last = way_.back();
      const double from = cycles_gone(knot_of_command(command));
      if (!loop_repeats_gait() && from >= cycles())
        out_.error(command.at.place, "the gait has ended by then",
                   "raise 'cycles', or write 'repeat: gait' in a closed loop");
      const double time = cycle_of_way();
      way_.push_back({from,
                      followed_by(last.before, along_arc(last.step, from - last.from)),
                      {time * command.x, time * command.y, time * command.turn}});
    }
  }

  /// True if a closed loop extends the gait to the loop's duration.
  bool loop_repeats_gait() const {
    return spec_.mpc && spec_.mpc->repeat.value == AfterTheEnd::kGait;
  }

  int knot_of_command(const GaitCommand& command) const {
    const double knot = std::min<double>(command.at.value / gait_.dt.value, kMaxKnots);
    return static_cast<int>(std::lround(knot));
  }

  /// Duration of a cycle of the base's path, s.
  double cycle_of_way() const {
    const double knots =
        earliest_ == latest_ ? period_ : static_cast<double>(way_end() - way_begin()) / cycles();
    return knots * gait_.dt.value;
  }

  /// Progress of the base along its path at a knot, in cycles.
  double cycles_gone(int knot) const {
    if (earliest_ != latest_)
      return cycles() *
             std::clamp(static_cast<double>(knot - way_begin()) / (way_end() - way_begin()), 0.0,
                        1.0);
    const int since = knot - lift_off(0, 0);
    if (since <= 0) return 0;
    const double gone =
        since / period_ + std::min(1.0, static_cast<double>(since % period_) / swing_);
    return std::min<double>(gone, cycles());
  }

  /// Rounds to 1e-12 m or rad: an expanded file shows 0.2, not 0.19999999999999998.
  static double rounded(double value) { return std::round(value * 1e12) / 1e12; }

  /// The motion up to a share of the entire path.
  PlanarMotion motion(double share) const {
    const double gone = share * cycles();
    std::size_t part = way_.size() - 1;
    while (part > 0 && gone < way_[part].from) --part;
    const PlanarMotion exact =
        followed_by(way_[part].before, along_arc(way_[part].step, gone - way_[part].from));
    return {rounded(exact.x), rounded(exact.y), rounded(exact.yaw)};
  }

  /// The same with the rise of the terrain under the feet.
  PlanarMotion base(double share) const {
    PlanarMotion motion = this->motion(share);
    motion.rise = rounded(rise_.at(share));
    return motion;
  }

  /// The landings of each foot.
  std::vector<PathOfFoot> paths_of_feet() const {
    std::vector<PathOfFoot> paths;
    for (int foot = 0; foot < foot_count(); ++foot) {
      paths.push_back({contact_of(foot).frame});
      for (int cycle = 0; cycle < cycles(); ++cycle) {
        paths.back().shares.push_back(landing(foot, cycle));
        paths.back().motions.push_back(motion(landing(foot, cycle)));
      }
    }
    return paths;
  }

  double landing(int foot, int cycle) const {
    return std::min(1.0, (cycle + 1 - latest_ + feet_[foot].start) / (cycles() - latest_));
  }

  void make_costs() {
    std::vector<CostSpec> costs;
    for (int foot = 0; foot < foot_count(); ++foot) {
      costs.push_back(swing_cost(foot));
      check_name(costs.back(), gait_.feet[foot].contact.value);
    }
    spec_.costs.insert(spec_.costs.end(), costs.begin(), costs.end());
  }

  const ContactSpec& contact_of(int foot) const {
    const std::string& name = gait_.feet[foot].contact.value;
    return *std::ranges::find_if(spec_.contacts,
                                 [&](const ContactSpec& c) { return c.name.value == name; });
  }

  CostSpec swing_cost(int foot) const {
    const Name& contact = gait_.feet[foot].contact;
    const ContactSpec& on = contact_of(foot);
    const bool sole = on.kind == ContactKind::surface;
    const char* residual = sole ? "frame_placement" : "frame_position";
    SwingSpec swing{.place = gait_.place, .height = gait_.step_height};
    for (int cycle = 0; cycle < cycles(); ++cycle)
      swing.displaced.push_back(motion(landing(foot, cycle)));
    CostSpec cost{.name = {"swing_" + contact.value, gait_.place},
                  .residual = {residual, gait_.place},
                  .definition = find_residual(residual),
                  .weight = gait_.weight};
    cost.keys.set(key::frame, {on.frame.value, contact.place});
    cost.keys.set(key::swing, std::move(swing));
    cost.phases = swing_phases_[foot];
    return cost;
  }

  /// Reports costs of the file that have the name of a swing cost.
  void check_name(const CostSpec& swing, const std::string& contact) {
    for (const CostSpec& other : spec_.costs)
      if (other.name.value == swing.name.value)
        out_.error(other.name.place,
                   fmt::format("the gait makes a cost '{}' for the swings of '{}'",
                               swing.name.value, contact),
                   "give this cost another name");
  }

  /// Node number of a knot, including the choice of the start and the impulses before it.
  int node(int knot) const {
    return before_ + knot +
           static_cast<int>(std::count_if(impulses_.begin(), impulses_.end(),
                                          [&](int impulse) { return impulse < knot; }));
  }

  /// Knots with the base's progress along its path there.
  std::vector<std::pair<int, double>> way() const {
    if (cycles() == 0) return {{0, 0.0}};
    return earliest_ == latest_ ? way_of_hops() : way_of_steps();
  }

  /// If all feet swing together, the base moves only during their swings.
  std::vector<std::pair<int, double>> way_of_hops() const {
    std::vector<std::pair<int, double>> points;
    for (int cycle = 0; cycle < cycles(); ++cycle) {
      points.emplace_back(lift_off(0, cycle), static_cast<double>(cycle) / cycles());
      points.emplace_back(touch_down(0, cycle), (cycle + 1.0) / cycles());
    }
    return points;
  }

  /// The middles of the first and the last swing, between which the base moves.
  int way_begin() const { return knot_of_start(earliest_) + swing_ / 2; }
  int way_end() const { return knot_of_start(latest_) + (cycles() - 1) * period_ + swing_ / 2; }

  std::vector<std::pair<int, double>> way_of_steps() const {
    const int first = way_begin(), last = way_end();
    std::set<int> knots;
    // Straight pieces of half a cycle approximate an arc closely enough.
    const int pieces = gait_.turn == 0 && gait_.commands.empty() ? 1 : 2 * cycles();
    for (int i = 0; i <= pieces; ++i)
      knots.insert(first +
                   static_cast<int>(std::lround(static_cast<double>(i) * (last - first) / pieces)));
    for (const GaitCommand& command : gait_.commands)
      if (const int knot = knot_of_command(command); knot > first && knot < last)
        knots.insert(knot);
    for (const double share : rise_.bends())
      knots.insert(first + static_cast<int>(std::lround(share * (last - first))));
    std::vector<std::pair<int, double>> points;
    for (const int knot : knots)
      points.emplace_back(knot, static_cast<double>(knot - first) / (last - first));
    return points;
  }

  /// True for a reference that is a single state displaced with the gait.
  static bool goes_with_gait(const ReferenceSpec& reference) {
    if (reference.values.size() != 1 || !reference.times.empty() || !reference.knots.empty())
      return false;
    const std::optional<StateSpec>& state = reference.values.front().state;
    return state && state->displaced && state->displaced->with_gait;
  }

  /// Sets the way-points of a reference that follows the gait, or at the last node its final value.
  void lead(CostSpec& cost, bool terminal) const {
    if (!cost.reference || !goes_with_gait(*cost.reference)) return;
    ReferenceSpec& reference = *cost.reference;
    const ReferenceValueSpec value = reference.values.front();
    if (terminal) {
      reference.values = {displaced(value, base(1.0))};
      return;
    }
    reference.values.clear();
    const std::vector<WayPoint>& points = spec_.gait_way;
    for (const auto& [node, motion] : points) {
      reference.values.push_back(displaced(value, motion));
      if (points.size() > 1) reference.knots.push_back({node, value.place});
    }
  }

  /// The value of a reference after a motion.
  static ReferenceValueSpec displaced(ReferenceValueSpec value, const PlanarMotion& motion) {
    value.state->displaced = {.place = value.state->displaced->place, .motion = motion};
    return value;
  }

  const GaitSpec& gait_;
  ProblemSpec& spec_;
  Diagnostics& out_;
  int before_;                                        ///< phases before the gait, of one knot each
  int begin_ = 0, period_ = 0, swing_ = 0, end_ = 0;  ///< knots
  double earliest_ = 0, latest_ = 0;                  ///< of the feet's starts
  std::vector<FootSteps> feet_;
  std::vector<WayPart> way_;
  GaitRise rise_;                                ///< 0 without terrain
  std::vector<std::vector<Name>> swing_phases_;  ///< per foot
  std::vector<int> impulses_;                    ///< knots
};

}  // namespace

void add_gait(ProblemSpec& spec, Diagnostics& out) {
  if (spec.gait) GaitSchedule(*spec.gait, spec, out).add();
}

}  // namespace conddp
