#include "output/schedule/contact_schedule.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "base/json/relative_paths.hpp"
#include "output/schedule/contact_surfaces.hpp"
#include "output/schedule/softened_constraint.hpp"
#include "problem_file/expand/expand_problem.hpp"

namespace conddp {
namespace {

/// Initial penalty of solvers with constraints: the guess nearly satisfies them, and a small
/// penalty would lose that.
constexpr double kPenalty = 100;
/// Tolerance on the distance of a held contact from its surface, m, unless the motion deviates
/// more.
constexpr double kHeldWithin = 1e-3;

class Writer {
 public:
  Writer(const BuiltProblem& built, const ContactMotion& motion, const ScheduleOptions& options)
      : facts_(built.facts()),
        built_(built),
        motion_(motion),
        options_(options),
        surfaces_(motion),
        sequence_(contact_sequence(motion, options.sequence)),
        json_(expand_problem(built)) {}

  ContactSchedule write() {
    json_["name"] = facts_.name.value + "_scheduled";
    json_.erase("contact_candidates");
    json_.erase("stepping");
    json_["integrator"] = "semi_implicit_euler";
    find_contacts();
    json_["contacts"] = contacts();
    phases();
    rename_phases(json_["costs"]);
    rename_phases(json_["constraints"]);
    add_constraints();
    leave_out_steps();
    if (!options_.supports_constraints) soften_constraints(json_, notes_);
    json_.erase("initial_guess");
    make_paths_relative(json_, facts_.file.parent_path(), options_.folder);
    json_["initial_guess"] = guess();
    json_["solver"] = {{"name", options_.solver}};
    if (options_.supports_constraints && options_.solver != "ipopt")
      json_["solver"]["augmented_lagrangian"] = {{"initial_penalty", kPenalty}};
    return {std::move(json_), std::move(notes_)};
  }

 private:
  /// A contact of the schedule: a candidate at a surface with one normal. If `guided`, it is
  /// constrained along the normal only, otherwise also along the tangents.
  struct Used {
    std::size_t candidate;
    Vector3<double> normal;
    bool guided;
    std::string name;
  };

  /// Phases of a candidate held at a surface, and the ends of its stretches.
  struct Held {
    std::vector<std::string> phases;
    std::vector<int> ends;     ///< nodes at the ends of stretches
    double off = kHeldWithin;  ///< m
  };

  const CandidateSpec& candidate(std::size_t c) const { return facts_.candidates[c]; }
  const std::string& name(std::size_t c, const ContactStretch& stretch) const {
    return std::find_if(used_.begin(), used_.end(),
                        [&](const Used& used) { return is(used, c, stretch); })
        ->name;
  }
  bool is(const Used& used, std::size_t c, const ContactStretch& stretch) const {
    return used.candidate == c && used.guided != is_held(c, stretch) &&
           is_same_normal(used.normal, surfaces_.normal(c, stretch.first));
  }

  bool moves(std::size_t c, const ContactStretch& stretch) const {
    return stretch.slides[c] || rolls(c, stretch);
  }
  bool rolls(std::size_t c, const ContactStretch& stretch) const {
    return candidate(c).radius > 0 && !stretch.slides[c] &&
           surfaces_.travels(c, stretch.first, stretch.first + stretch.steps,
                             ContactSequenceOptions{}.slip);
  }
  /// True if a closed candidate is also held along its tangents: it must not move. In a plane, only
  /// the candidate of a body with the largest load is held, because two would overconstrain the
  /// body.
  bool is_held(std::size_t c, const ContactStretch& stretch) const {
    if (moves(c, stretch) || candidate(c).friction == 0) return false;
    if (!facts_.stepping->plane) return true;
    for (std::size_t other = 0; other < stretch.closed.size(); ++other)
      if (rests_on_same_body(other, c, stretch) && carries_more(other, c, stretch)) return false;
    return true;
  }

  /// True if `other` is a different closed candidate of the same body and does not move.
  bool rests_on_same_body(std::size_t other, std::size_t c, const ContactStretch& stretch) const {
    return other != c && stretch.closed[other] && !moves(other, stretch) && body(other) == body(c);
  }
  /// True if candidate a carries more load than b; the first one wins a tie.
  bool carries_more(std::size_t a, std::size_t b, const ContactStretch& stretch) const {
    const double of_a = load(a, stretch), of_b = load(b, stretch);
    return of_a > of_b || (of_a == of_b && a < b);
  }
  int body(std::size_t c) const {
    const RobotModel& robot = *motion_.plant.robot;
    return robot.frames[motion_.plant.contacts.candidates[c].sphere.frame].joint;
  }
  double load(std::size_t c, const ContactStretch& stretch) const {
    double sum = 0;
    for (int k = stretch.first; k < stretch.first + stretch.steps; ++k)
      sum += motion_.forces[k].contact(0, c);
    return sum;
  }

  void find_contacts() {
    for (const ContactStretch& stretch : sequence_)
      for (std::size_t c = 0; c < stretch.closed.size(); ++c) {
        if (!stretch.closed[c]) continue;
        check(c, stretch);
        if (std::none_of(used_.begin(), used_.end(),
                         [&](const Used& used) { return is(used, c, stretch); }))
          add_contact(c, stretch);
      }
  }

  void check(std::size_t c, const ContactStretch& stretch) const {
    const CandidateSpec& used = candidate(c);
    const auto refuse = [&](const char* what) {
      throw NoSchedule{fmt::format("the contact '{}' {}", used.name.value, what)};
    };
    if (used.against.frame)
      refuse("is with a body of the robot: a schedule supports only contacts with the world");
    if (used.stiffness) refuse("is soft: contacts of a schedule are rigid");
    if (squared_norm(used.point) != 0)
      refuse("is not at the origin of its frame: give the robot a frame there");
    if (!surfaces_.touched(c, stretch.first, stretch.first + stretch.steps))
      refuse(
          "moves round an edge or along a curved surface: a contact of a schedule has one normal");
  }

  /// The first contact of a candidate has its name; further normals add a number.
  void add_contact(std::size_t c, const ContactStretch& stretch) {
    const Vector3<double>& normal = surfaces_.normal(c, stretch.first);
    const std::string& own = candidate(c).name.value;
    const bool guided = !is_held(c, stretch);
    const auto number = 1 + std::count_if(used_.begin(), used_.end(), [&](const Used& used) {
                          return used.candidate == c && used.guided == guided;
                        });
    std::string name = own + (guided ? "_normal" : "");
    if (number > 1) name += fmt::format("_{}", number);
    used_.push_back({c, normal, guided, name});
    if (moves(c, stretch) && candidate(c).friction > 0)
      note(fmt::format("'{}' {}: there it is held along the normal alone, without friction", own,
                       rolls(c, stretch) ? "rolls" : "slides"));
    if (!guided && candidate(c).radius > 0)
      note(fmt::format("the middle of '{}' is held, so that it does not roll", own));
  }

  /// Adds a note unless it exists.
  void note(std::string text) {
    if (std::find(notes_.begin(), notes_.end(), text) == notes_.end())
      notes_.push_back(std::move(text));
  }

  OrderedJson contacts() const {
    OrderedJson json = OrderedJson::object();
    for (const Used& used : used_) json[used.name] = contact(used);
    return json;
  }

  OrderedJson contact(const Used& used) const {
    const CandidateSpec& from = candidate(used.candidate);
    const Vector3<double>& n = used.normal;
    OrderedJson json = {{"frame", from.frame.value},
                        {"type", used.guided              ? "normal"
                                 : facts_.stepping->plane ? "planar"
                                                          : "point"},
                        {"normal", {n.x, n.y, n.z}}};
    if (!used.guided && facts_.stepping->plane) {
      const Vector3<double> t = cross(*facts_.stepping->plane, n);
      json["tangent"] = {t.x, t.y, t.z};
    }
    if (from.friction > 0) json["friction"] = from.friction;
    json["min_normal_force"] = 0;
    // Removes the residual velocity of a touch-down within a few steps; stable for every step.
    const double longest = *std::max_element(motion_.h.begin(), motion_.h.end());
    json["baumgarte"] = {{"kp", 0}, {"kd", std::min(20.0, 0.5 / longest)}};
    return json;
  }

  /// Suffix that distinguishes the obstacles of a candidate: the faces of a box.
  std::string suffix(std::size_t c, int surface) const {
    return surfaces_.count(c) > 1 ? fmt::format("_face_{}", surface + 1) : "";
  }

  /// Names of a candidate's shape and of a surface, which are created on first use.
  OrderedJson pair(std::size_t c, int surface) {
    const std::string& own = candidate(c).name.value;
    const std::string shape = own + "_shape", obstacle = own + "_obstacle" + suffix(c, surface);
    const Vector3<double>& center = candidate(c).point;
    // A point becomes a ball over a surface that is lower by the ball's radius.
    const double radius = candidate(c).radius > 0 ? candidate(c).radius : point_radius(c);
    json_["collision"]["shapes"][shape] = {
        {"frame", candidate(c).frame.value},
        {"sphere", {{"radius", radius}, {"center", {center.x, center.y, center.z}}}}};
    json_["collision"]["obstacles"][obstacle] =
        surfaces_.obstacle(c, surface, radius - candidate(c).radius);
    return {shape, obstacle};
  }

  /// Radius of the ball at a point: at most half the counterpart's radius, m.
  double point_radius(std::size_t c) const {
    const auto* sphere = std::get_if<SphereSpec>(&candidate(c).against.form);
    return sphere == nullptr ? kPointRadius : std::min(kPointRadius, 0.5 * sphere->radius);
  }

  /// For each open candidate, the surface that it must stay away from, starting at step k.
  std::vector<std::optional<int>> surfaces_ahead(const ContactStretch& stretch, int k) const {
    std::vector<std::optional<int>> list(stretch.closed.size());
    for (std::size_t c = 0; c < list.size(); ++c)
      if (!stretch.closed[c] && surfaces_.count(c) > 0)
        list[c] = surfaces_.count(c) == 1 ? 0 : surfaces_.longest_outside(c, k);
    return list;
  }

  /// True if the surfaces still apply at a later step.
  bool are_ahead(const std::vector<std::optional<int>>& list, const ContactStretch& stretch,
                 int k) const {
    for (std::size_t c = 0; c < list.size(); ++c)
      if (!stretch.closed[c] && surfaces_.count(c) > 1 &&
          !(list[c] ? surfaces_.is_outside(c, *list[c], k) : !surfaces_.longest_outside(c, k)))
        return false;
    return true;
  }

  /// Writes the phases: runs of steps with the same contacts in the same original phase and of the
  /// same length, while open candidates stay away from the same faces of boxes.
  void phases() {
    const OrderedJson original = json_["phases"];
    OrderedJson list = OrderedJson::array();
    int k = 0, number = 0;
    for (const OrderedJson& phase : original) {
      if (phase.contains("choose")) {  // initial state is chosen as before
        list.push_back(phase);
        continue;
      }
      for (int end = k + phase["knots"].get<int>(); k < end; ++number)
        k = add_phase(phase, number, k, end, list);
    }
    json_["phases"] = std::move(list);
  }

  /// Adds the run that begins at step k, within the steps before `end`; returns the step after it.
  int add_phase(const OrderedJson& phase, int number, int k, int end, OrderedJson& list) {
    const std::string base = phase["name"], own = fmt::format("{}_{}", base, number);
    const ContactStretch& stretch = stretch_of(k);
    if (k == stretch.first && stretch.lands()) land(stretch, own, list);
    const int first = k;
    const auto ahead = surfaces_ahead(stretch, first);
    end = std::min(end, stretch.first + stretch.steps);
    while (k < end && std::abs(motion_.h[k] - motion_.h[first]) <= 1e-12 * motion_.h[first] &&
           are_ahead(ahead, stretch, k))
      ++k;
    OrderedJson entry = {{"name", own}, {"knots", k - first}, {"dt", motion_.h[first]}};
    entry["contacts"] = names(stretch);
    if (phase.contains("weights")) entry["weights"] = phase["weights"];
    list.push_back(std::move(entry));
    renamed_[base].push_back(own);
    note_open(stretch, ahead, own);
    note_held(stretch, own, first, k);
    return k;
  }

  /// Records the closed candidates of a phase from step `first` to `end`.
  void note_held(const ContactStretch& stretch, const std::string& phase, int first, int end) {
    for (std::size_t c = 0; c < stretch.closed.size(); ++c) {
      if (!stretch.closed[c]) continue;
      const int surface = *surfaces_.touched(c, stretch.first, stretch.first + stretch.steps);
      Held& held = held_[{c, surface}];
      held.phases.push_back(phase);
      for (int k = first; k <= end; ++k)
        held.off = std::max(held.off, std::abs(surfaces_.gap(c, k)));
      if (!held.ends.empty() && held.ends.back() == first) held.ends.pop_back();
      held.ends.push_back(end);
    }
  }

  /// Records the surfaces that open candidates stay away from in a phase.
  void note_open(const ContactStretch& stretch, const std::vector<std::optional<int>>& ahead,
                 const std::string& phase) {
    for (std::size_t c = 0; c < ahead.size(); ++c) {
      if (ahead[c])
        open_phases_[{c, *ahead[c]}].push_back(phase);
      else if (!stretch.closed[c] && surfaces_.count(c) > 0)
        notes_.push_back(fmt::format("nothing keeps '{}' off the box in the phase '{}'",
                                     candidate(c).name.value, phase));
    }
  }

  void land(const ContactStretch& stretch, const std::string& before, OrderedJson& list) {
    const std::string own = before + "_landing";
    list.push_back({{"name", own}, {"impulse", names(stretch)}, {"restitution", 0}});
    for (std::size_t c = 0; c < stretch.landing.size(); ++c)
      if (stretch.landing[c])
        landings_[own].push_back(
            pair(c, *surfaces_.touched(c, stretch.first, stretch.first + stretch.steps)));
    impulses_.push_back(stretch.first);
  }

  OrderedJson names(const ContactStretch& stretch) const {
    OrderedJson list = OrderedJson::array();
    for (std::size_t c = 0; c < stretch.closed.size(); ++c)
      if (stretch.closed[c]) list.push_back(name(c, stretch));
    return list;
  }

  const ContactStretch& stretch_of(int k) const {
    for (const ContactStretch& stretch : sequence_)
      if (k < stretch.first + stretch.steps) return stretch;
    return sequence_.back();
  }

  OrderedJson renamed(const OrderedJson& phases) const {
    OrderedJson list = OrderedJson::array();
    for (const auto& former : phases)
      for (const std::string& own : renamed_.at(former.get<std::string>())) list.push_back(own);
    return list;
  }

  /// Replaces names of phases and numbers of knots by those of the new file.
  void rename_phases(OrderedJson& terms) const {
    for (auto& [key, term] : terms.items()) {
      if (term.contains("phases")) term["phases"] = renamed(term["phases"]);
      if (term.contains("knots"))
        for (auto& knot : term["knots"]) knot = number_of(knot.get<int>());
    }
  }

  void add_constraints() {
    OrderedJson& constraints = json_["constraints"];
    if (!used_.empty())
      constraints["contact_cones"] = {{"residual", "friction_cone"}, {"contacts", "all"}};
    for (const auto& [off, phases] : open_phases_) {
      const auto& [c, surface] = off;
      OrderedJson pairs = OrderedJson::array();
      pairs.push_back(pair(c, surface));
      constraints["contact_height_" + candidate(c).name.value + suffix(c, surface)] = {
          {"residual", "distance"}, {"pairs", pairs}, {"lower", -kGrazing}, {"phases", phases}};
    }
    for (const auto& [on, held] : held_) hold(on.first, on.second, held, constraints);
    for (const auto& [phase, landing] : landings_)
      constraints["contact_" + phase] = {
          {"residual", "distance"}, {"pairs", landing}, {"equals", 0}, {"phases", {phase}}};
    stops(constraints);
    for (const auto& [joint, limit] : facts_.stepping->joint_friction)
      notes_.push_back(fmt::format("dry friction of '{}' is left out", joint.value));
  }

  /// Contacts are held at the acceleration level, so a step that begins or ends with velocity would
  /// leave the surface. The distance is therefore bounded during each stretch and at its end.
  void hold(std::size_t c, int surface, const Held& held, OrderedJson& constraints) {
    const std::string name = "contact_held_" + candidate(c).name.value + suffix(c, surface);
    OrderedJson pairs = OrderedJson::array();
    pairs.push_back(pair(c, surface));
    OrderedJson distance = {{"residual", "distance"}, {"pairs", pairs}};
    distance["lower"] = -held.off;
    distance["upper"] = held.off;
    OrderedJson& during = constraints[name] = distance;
    during["phases"] = held.phases;
    OrderedJson knots = OrderedJson::array();
    for (const int end : held.ends) {
      if (end == static_cast<int>(motion_.h.size()))
        json_["terminal"]["constraints"][name] = distance;
      else
        knots.push_back(number_of(end + motion_.first_knot));
    }
    if (knots.empty()) return;
    OrderedJson& after = constraints[name + "_until"] = distance;
    after["knots"] = knots;
  }

  /// Index in the new file of a knot of the original file.
  int number_of(int knot) const {
    return knot +
           static_cast<int>(std::count_if(impulses_.begin(), impulses_.end(), [&](int first) {
             return first + motion_.first_knot <= knot;
           }));
  }

  /// Joint stops by column, for joints that have them.
  OrderedJson stops_at(double JointStop::*end) const {
    OrderedJson list = OrderedJson::object();
    for (const JointStop& stop : motion_.plant.contacts.stops)
      if (std::isfinite(stop.*end))
        list["q/" + motion_.plant.robot->joints[stop.joint].name] = stop.*end;
    return list;
  }

  void stops(OrderedJson& constraints) const {
    const OrderedJson lower = stops_at(&JointStop::lower), upper = stops_at(&JointStop::upper);
    if (lower.empty() && upper.empty()) return;
    OrderedJson& entry = constraints["joint_stops"];
    entry["bounds"] = "configuration";
    if (!lower.empty()) entry["lower"] = lower;
    if (!upper.empty()) entry["upper"] = upper;
  }

  /// Removes costs and bounds on accelerations, forces and slacks of a step, which no longer exist.
  void leave_out_steps() {
    const auto of_steps = [&](const std::string& column) {
      for (std::size_t i = motion_.u_lower.size(); i < built_.control_columns.size(); ++i)
        if (built_.control_columns[i].name == column) return true;
      return false;
    };
    for (const char* section : {"costs", "constraints"}) {
      OrderedJson kept = OrderedJson::object();
      for (const auto& [key, term] : json_[section].items()) {
        const bool out =
            term.contains("columns") && std::any_of(term["columns"].begin(), term["columns"].end(),
                                                    [&](const auto& c) { return of_steps(c); });
        if (out)
          notes_.push_back(fmt::format("'{}' is left out: it is on forces or slacks", key));
        else
          kept[key] = term;
      }
      json_[section] = std::move(kept);
    }
  }

  OrderedJson guess() const {
    OrderedJson states = OrderedJson::array(), controls = OrderedJson::array();
    for (const Column& column : built_.plant.system->state_columns()) states.push_back(column.name);
    for (int i = 0; i < motion_.u_lower.size(); ++i)
      controls.push_back(built_.control_columns[i].name);
    const std::string file = relative_path(options_.solution, options_.folder);
    return {{"states", {{"file", file}, {"columns", states}}},
            {"controls", {{"file", file}, {"columns", controls}}}};
  }

  static constexpr double kPointRadius = 0.01;  // m

  const ProblemFacts& facts_;
  const BuiltProblem& built_;
  const ContactMotion& motion_;
  const ScheduleOptions& options_;
  const ContactSurfaces surfaces_;
  const std::vector<ContactStretch> sequence_;
  OrderedJson json_;
  std::vector<std::string> notes_;
  std::vector<Used> used_;
  std::map<std::string, std::vector<std::string>> renamed_;
  /// By open candidate and surface that it stays away from.
  std::map<std::pair<std::size_t, int>, OrderedJson> open_phases_;
  std::map<std::pair<std::size_t, int>, Held> held_;  ///< by candidate and surface
  std::map<std::string, OrderedJson> landings_;       ///< pairs that touch at each impulse
  std::vector<int> impulses_;                         ///< steps after the impulses
};

}  // namespace

ContactSchedule contact_schedule(const BuiltProblem& built, const ContactMotion& motion,
                                 const ScheduleOptions& options) {
  return Writer(built, motion, options).write();
}

}  // namespace conddp
