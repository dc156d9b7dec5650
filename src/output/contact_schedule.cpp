#include "output/contact_schedule.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "output/softened_constraint.hpp"
#include "problem_file/expand_problem.hpp"

namespace conddp {
namespace {

/// Of costs that stand for constraints: while the motion runs, and at single nodes. Larger ones
/// make stages that a solver without constraints hardly gets to the end of.
constexpr double kRunningWeight = 100, kNodeWeight = 1000;
/// First penalty of solvers that keep constraints: the guess nearly satisfies them, and a small one
/// would first give that away.
constexpr double kPenalty = 100;

class Writer {
 public:
  Writer(const ProblemSpec& spec, const BuiltProblem& built, const ContactMotion& motion,
         const ScheduleOptions& options)
      : spec_(spec),
        built_(built),
        motion_(motion),
        options_(options),
        sequence_(contact_sequence(motion, options.sequence)),
        json_(expand_problem(spec, built)) {}

  ContactSchedule write() {
    json_["name"] = spec_.name.value + "_scheduled";
    json_.erase("contact_candidates");
    json_.erase("stepping");
    json_["integrator"] = "semi_implicit_euler";
    find_contacts();
    json_["contacts"] = contacts();
    place_shapes();
    phases();
    rename_phases(json_["costs"]);
    rename_phases(json_["constraints"]);
    add_constraints();
    leave_out_steps();
    if (!options_.keeps_constraints) soften();
    json_.erase("initial_guess");
    paths(json_, spec_.file.parent_path());
    json_["initial_guess"] = guess();
    json_["solver"] = {{"name", options_.solver}};
    if (options_.keeps_constraints && options_.solver != "ipopt")
      json_["solver"]["augmented_lagrangian"] = {{"initial_penalty", kPenalty}};
    return {std::move(json_), std::move(notes_)};
  }

 private:
  /// What becomes of a candidate somewhere in the schedule.
  struct Used {
    bool held = false, guided = false, slides = false, plane = false;
  };

  const CandidateSpec& candidate(std::size_t c) const { return spec_.candidates[c]; }
  /// The contact along the normal alone.
  std::string guide(std::size_t c) const { return candidate(c).name.value + "_normal"; }
  std::string name(std::size_t c, const ContactStretch& stretch) const {
    return is_held(c, stretch) ? candidate(c).name.value : guide(c);
  }

  /// Whether a closed candidate is held along its tangents, too: where it does not slide, and in a
  /// plane only the one of a body that carries most, as two would hold more than a body can do.
  bool is_held(std::size_t c, const ContactStretch& stretch) const {
    if (stretch.slides[c]) return false;
    if (!spec_.stepping->plane) return true;
    for (std::size_t other = 0; other < used_.size(); ++other)
      if (other != c && stretch.closed[other] && !stretch.slides[other] && body(other) == body(c) &&
          (load(other, stretch) > load(c, stretch) ||
           (load(other, stretch) == load(c, stretch) && other < c)))
        return false;
    return true;
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
    used_.resize(spec_.candidates.size());
    for (const ContactStretch& stretch : sequence_)
      for (std::size_t c = 0; c < used_.size(); ++c) {
        if (!stretch.closed[c]) continue;
        check(candidate(c));
        (is_held(c, stretch) ? used_[c].held : used_[c].guided) = true;
        used_[c].slides = used_[c].slides || stretch.slides[c];
      }
  }

  void check(const CandidateSpec& used) const {
    const auto refuse = [&](const char* what) {
      throw NoSchedule{fmt::format("the contact '{}' {}", used.name.value, what)};
    };
    if (used.against.frame) refuse("is with a body of the robot: a schedule has the world alone");
    if (!std::holds_alternative<HalfSpaceSpec>(used.against.form))
      refuse("is with a sphere or box: a schedule has planes alone");
    if (used.stiffness) refuse("is soft: contacts of a schedule are rigid");
    if (squared_norm(used.point) != 0)
      refuse("is not at the origin of its frame: give the robot a frame there");
  }

  OrderedJson contacts() {
    OrderedJson json = OrderedJson::object();
    for (std::size_t c = 0; c < used_.size(); ++c) {
      if (used_[c].held) json[candidate(c).name.value] = contact(c, false);
      if (used_[c].guided) json[guide(c)] = contact(c, true);
      if (used_[c].slides)
        notes_.push_back(
            fmt::format("'{}' slides: there it is held along the normal alone, without "
                        "friction",
                        candidate(c).name.value));
      if (used_[c].held && candidate(c).radius > 0)
        notes_.push_back(fmt::format("the middle of '{}' is held, so that it does not roll",
                                     candidate(c).name.value));
    }
    return json;
  }

  OrderedJson contact(std::size_t c, bool guided) const {
    const CandidateSpec& from = candidate(c);
    const Vector3<double>& n = std::get<HalfSpaceSpec>(from.against.form).normal;
    OrderedJson json = {{"frame", from.frame.value},
                        {"type", guided                  ? "normal"
                                 : spec_.stepping->plane ? "planar"
                                                         : "point"},
                        {"normal", {n.x, n.y, n.z}}};
    if (!guided && spec_.stepping->plane) {
      const Vector3<double> t = cross(*spec_.stepping->plane, n);
      json["tangent"] = {t.x, t.y, t.z};
    }
    json["friction"] = from.friction;
    json["min_normal_force"] = 0;
    // Stops what is left of a touch-down within a few steps, and is stable for every step.
    const double longest = *std::max_element(motion_.h.begin(), motion_.h.end());
    json["baumgarte"] = {{"kp", 0}, {"kd", std::min(20.0, 0.5 / longest)}};
    return json;
  }

  std::string shape(std::size_t c) const { return candidate(c).name.value + "_shape"; }
  std::string plane(std::size_t c) const { return candidate(c).name.value + "_plane"; }

  /// What may not penetrate: every candidate that is a ball or point over a plane of the world.
  void place_shapes() {
    for (std::size_t c = 0; c < used_.size(); ++c) {
      const auto* solid = std::get_if<HalfSpaceSpec>(&candidate(c).against.form);
      if (solid == nullptr || candidate(c).against.frame || candidate(c).stiffness) continue;
      const Vector3<double>& center = candidate(c).point;
      // A point is a ball over a plane that lies deeper by its radius.
      const double radius = candidate(c).radius > 0 ? candidate(c).radius : kPointRadius;
      const Vector3<double> on_plane =
          solid->point - (radius - candidate(c).radius) * solid->normal;
      json_["collision"]["shapes"][shape(c)] = {
          {"frame", candidate(c).frame.value},
          {"sphere", {{"radius", radius}, {"center", {center.x, center.y, center.z}}}}};
      json_["collision"]["obstacles"][plane(c)] = {
          {"half_space",
           {{"normal", {solid->normal.x, solid->normal.y, solid->normal.z}},
            {"point", {on_plane.x, on_plane.y, on_plane.z}}}}};
      used_[c].plane = true;
    }
  }

  /// Runs of steps with the same contacts in the same phase of the problem and of the same length.
  void phases() {
    const OrderedJson original = json_["phases"];
    OrderedJson list = OrderedJson::array();
    int k = 0, number = 0;
    open_phases_.assign(used_.size(), OrderedJson::array());
    for (const OrderedJson& phase : original) {
      if (phase.contains("choose")) {  // the first state is chosen as it was
        list.push_back(phase);
        continue;
      }
      const std::string base = phase["name"];
      for (int end = k + phase["knots"].get<int>(); k < end; ++number) {
        const ContactStretch& stretch = stretch_of(k);
        const std::string own = fmt::format("{}_{}", base, number);
        if (k == stretch.first && stretch.lands()) land(stretch, own, list);
        const int first = k;
        while (k < end && k < stretch.first + stretch.steps &&
               std::abs(motion_.h[k] - motion_.h[first]) <= 1e-12 * motion_.h[first])
          ++k;
        OrderedJson entry = {{"name", own}, {"knots", k - first}, {"dt", motion_.h[first]}};
        entry["contacts"] = names(stretch);
        if (phase.contains("weights")) entry["weights"] = phase["weights"];
        list.push_back(std::move(entry));
        renamed_[base].push_back(own);
        for (std::size_t c = 0; c < used_.size(); ++c)
          if (!stretch.closed[c]) open_phases_[c].push_back(own);
      }
    }
    json_["phases"] = std::move(list);
  }

  void land(const ContactStretch& stretch, const std::string& before, OrderedJson& list) {
    const std::string own = before + "_landing";
    list.push_back({{"name", own}, {"impulse", names(stretch)}, {"restitution", 0}});
    for (std::size_t c = 0; c < stretch.landing.size(); ++c)
      if (stretch.landing[c]) landings_[own].push_back({shape(c), plane(c)});
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

  /// Names of phases and numbers of knots are those of the new file.
  void rename_phases(OrderedJson& terms) const {
    for (auto& [key, term] : terms.items()) {
      if (term.contains("phases")) {
        OrderedJson list = OrderedJson::array();
        for (const auto& former : term["phases"])
          for (const std::string& own : renamed_.at(former.get<std::string>())) list.push_back(own);
        term["phases"] = std::move(list);
      }
      if (term.contains("knots"))
        for (auto& knot : term["knots"]) {
          const int k = knot.get<int>();
          knot = k + std::count_if(impulses_.begin(), impulses_.end(),
                                   [&](int first) { return first + motion_.first_knot <= k; });
        }
    }
  }

  void add_constraints() {
    OrderedJson& constraints = json_["constraints"];
    if (!json_["contacts"].empty())
      constraints["contact_cones"] = {{"residual", "friction_cone"}, {"contacts", "all"}};
    for (std::size_t c = 0; c < used_.size(); ++c) {
      if (!used_[c].plane || open_phases_[c].empty()) continue;
      OrderedJson pairs = OrderedJson::array();
      pairs.push_back({shape(c), plane(c)});
      constraints["contact_height_" + candidate(c).name.value] = {{"residual", "distance"},
                                                                  {"pairs", pairs},
                                                                  {"lower", -kGrazing},
                                                                  {"phases", open_phases_[c]}};
    }
    for (const auto& [phase, landing] : landings_)
      constraints["contact_" + phase] = {
          {"residual", "distance"}, {"pairs", landing}, {"equals", 0}, {"phases", {phase}}};
    stops(constraints);
    for (const auto& [joint, limit] : spec_.stepping->joint_friction)
      notes_.push_back(fmt::format("dry friction of '{}' is left out", joint.value));
  }

  void stops(OrderedJson& constraints) const {
    OrderedJson lower = OrderedJson::object(), upper = OrderedJson::object();
    for (const JointStop& stop : motion_.plant.contacts.stops) {
      const std::string& joint = motion_.plant.robot->joints[stop.joint].name;
      if (std::isfinite(stop.lower)) lower["q/" + joint] = stop.lower;
      if (std::isfinite(stop.upper)) upper["q/" + joint] = stop.upper;
    }
    if (lower.empty() && upper.empty()) return;
    OrderedJson& entry = constraints["joint_stops"];
    entry["bounds"] = "configuration";
    if (!lower.empty()) entry["lower"] = lower;
    if (!upper.empty()) entry["upper"] = upper;
  }

  /// Costs and bounds on accelerations, forces and slacks of a step mean nothing any more.
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

  void soften() {
    const auto move = [&](OrderedJson& constraints, OrderedJson& costs, double weight) {
      OrderedJson kept = OrderedJson::object();
      for (const auto& [key, constraint] : constraints.items()) {
        if (constraint.value("bounds", "") == "control") {
          kept[key] = constraint;
          continue;
        }
        OrderedJson cost = softened(constraint, key.ends_with("_landing") ? kNodeWeight : weight);
        if (cost.is_null())
          notes_.push_back(fmt::format("the constraint '{}' is left out", key));
        else
          costs[key] = std::move(cost);
      }
      constraints = std::move(kept);
    };
    move(json_["constraints"], json_["costs"], kRunningWeight);
    move(json_["terminal"]["constraints"], json_["terminal"]["costs"], kNodeWeight);
  }

  OrderedJson guess() const {
    OrderedJson states = OrderedJson::array(), controls = OrderedJson::array();
    for (const Column& column : built_.plant.system->state_columns()) states.push_back(column.name);
    for (int i = 0; i < motion_.u_lower.size(); ++i)
      controls.push_back(built_.control_columns[i].name);
    const std::string file = relative(options_.solution);
    return {{"states", {{"file", file}, {"columns", states}}},
            {"controls", {{"file", file}, {"columns", controls}}}};
  }

  std::string relative(const std::filesystem::path& file) const {
    return std::filesystem::proximate(file, options_.folder.empty() ? "." : options_.folder)
        .generic_string();
  }

  /// Files that the problem names relative to its own folder.
  void paths(OrderedJson& json, const std::filesystem::path& from) const {
    if (!json.is_structured()) return;
    for (auto& [key, value] : json.items()) {
      if (value.is_string() && (key == "urdf" || key == "file"))
        value = relative(from / value.get<std::string>());
      else
        paths(value, from);
    }
  }

  static constexpr double kPointRadius = 0.01;  // m
  /// Of heights that are kept: a contact that rests may be so far off, m.
  static constexpr double kGrazing = 1e-4;

  const ProblemSpec& spec_;
  const BuiltProblem& built_;
  const ContactMotion& motion_;
  const ScheduleOptions& options_;
  const std::vector<ContactStretch> sequence_;
  OrderedJson json_;
  std::vector<std::string> notes_;
  std::vector<Used> used_;
  std::map<std::string, std::vector<std::string>> renamed_;
  std::vector<OrderedJson> open_phases_;         ///< of each candidate
  std::map<std::string, OrderedJson> landings_;  ///< pairs that touch at each impulse
  std::vector<int> impulses_;                    ///< steps before which they are
};

}  // namespace

ContactSchedule contact_schedule(const ProblemSpec& spec, const BuiltProblem& built,
                                 const ContactMotion& motion, const ScheduleOptions& options) {
  return Writer(spec, built, motion, options).write();
}

}  // namespace conddp
