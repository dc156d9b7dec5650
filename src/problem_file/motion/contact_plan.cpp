#include "problem_file/motion/contact_plan.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/motion/footholds.hpp"
#include "problem_file/plant/kept_goals.hpp"

namespace conddp {
namespace {

/// Largest angle between the z axis of a sole and its contact's normal without a warning, rad.
constexpr double kLevelSole = 0.15;
/// Gap of a closed loop in the initial state, m. Stabilization closes smaller ones.
constexpr double kClosedLoop = 1e-3;

/// The frame that a contact touches; reports one that cannot move relative to the contact's.
std::optional<int> find_base(const ContactSpec& spec, int frame, const RobotModel& robot,
                             Diagnostics& out) {
  const auto base = find_frame(robot, *spec.to, "", out);
  if (!base || robot.frames[*base].joint != robot.frames[frame].joint) return base;
  out.error(spec.to->place,
            fmt::format("the frames '{}' and '{}' are on one body: nothing can hold "
                        "them together",
                        spec.frame.value, spec.to->value));
  return std::nullopt;
}

std::optional<Contact> make_contact(const ContactSpec& spec, const Plant& plant,
                                    const std::vector<double>& initial, Diagnostics& out) {
  const auto frame = find_frame(plant.robot(), spec.frame, "", out);
  if (!frame) return std::nullopt;
  const RobotModel& robot = plant.robot();
  if (robot.frames[*frame].joint < 0) {
    out.error(spec.frame.place,
              fmt::format("the frame '{}' is fixed to the world: it cannot touch {}",
                          spec.frame.value, spec.to ? "another" : "it"),
              spec.to ? "exchange 'frame' and 'to'" : "");
    return std::nullopt;
  }
  std::optional<int> base;
  if (spec.to && !(base = find_base(spec, *frame, robot, out))) return std::nullopt;
  Contact contact = contact_of(spec, *frame, base);
  if (spec.kp == 0 && !spec.placement) return contact;
  const MultibodySystem& system = *plant.multibody();
  contact.reference = placement_in_state(system, initial, *frame);
  if (base)
    contact.reference = inverse(placement_in_state(system, initial, *base)) * contact.reference;
  if (spec.placement && spec.placement->position) contact.reference.p = *spec.placement->position;
  if (spec.placement && spec.placement->orientation)
    contact.reference.R = rotation_matrix(*spec.placement->orientation);
  return contact;
}

/// Gap of a loop; that of a surface has a length and an angle.
std::string gap_text(const Contact& loop, double gap, const MultibodySystem& system,
                     const std::vector<double>& x) {
  if (loop.kind != ContactKind::surface) return fmt::format("{:.3g} mm apart", 1e3 * gap);
  const SE3<double> error = inverse(loop.reference) *
                            inverse(placement_in_state(system, x, *loop.base)) *
                            placement_in_state(system, x, loop.frame);
  return fmt::format("{:.3g} mm apart and {:.3g} rad turned",
                     1e3 * std::sqrt(squared_norm(error.p)),
                     std::sqrt(squared_norm(log_so3(quaternion(error.R)))));
}

/// Warns once of a contact whose stabilization is unstable at the time step of a phase.
void warn_of_instability(const ContactSpec& contact, int index, const ContactPlan& plan,
                         const ProblemSpec& spec, Integrator integrator, Diagnostics& out) {
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const PhaseSpec& phase = spec.phases[p];
    if (!plan.find(p, index) || phase.takes_no_time() ||
        is_stable(integrator, contact.kp, contact.kd, phase.dt))
      continue;
    return out.warning(
        contact.baumgarte_place,
        fmt::format("the contact '{}' is stabilized more stiffly (kp {} 1/s², kd {} 1/s) than "
                    "the time step {} s of phase '{}' carries: errors grow",
                    contact.name.value, contact.kp, contact.kd, phase.dt, phase.name.value),
        contact.kp == 0 ? fmt::format("kd up to {:.3g} is stable with this step", 2 / phase.dt)
                        : "lower kp and kd, or take smaller steps");
  }
}

/// Warns of a sole whose z axis differs from the contact normal in the initial state. Wrench cones
/// and centers of pressure refer to the z axis of the sole's frame, whatever the normal.
void warn_of_sole(const ContactSpec& spec, const Contact& contact, const Plant& plant,
                  const std::vector<double>& initial, Diagnostics& out) {
  if (spec.kind != ContactKind::surface || !spec.half_size || spec.to) return;
  Vector3<double> normal = contact.normal;
  if (contact.axes == FrameAxes::world_aligned) {
    const auto sole = placement_in_state(*plant.multibody(), initial, contact.frame);
    normal = transpose(sole.R) * normal;
  }
  const double angle = std::acos(std::clamp(normal.z, -1.0, 1.0));
  if (angle <= kLevelSole) return;
  out.warning(spec.frame.place,
              fmt::format("the z axis of the sole '{}' is {:.0f}° off the normal of its contact "
                          "in the initial state: wrench cones and centers of pressure are about "
                          "that axis",
                          spec.frame.value, angle * 180 / std::numbers::pi),
              "take a frame whose z axis points out of the ground, or another 'normal'");
}

/// Warns of gravity that pulls away from the surfaces of all contacts: contacts push along their
/// normals.
void warn_of_gravity(const ProblemSpec& spec, Diagnostics& out) {
  const Vector3<double>& g = spec.gravity;
  const auto is_left = [&](const ContactSpec& contact) {
    return contact.to || (contact.axes == FrameAxes::world_aligned && dot(g, contact.normal) > 0);
  };
  const auto on_world = [](const ContactSpec& contact) { return !contact.to; };
  const auto found = std::ranges::find_if(spec.contacts, on_world);
  if (found == spec.contacts.end() || !std::ranges::all_of(spec.contacts, is_left)) return;
  const ContactSpec& first = *found;
  const Vector3<double>& n = first.normal;
  out.warning(first.name.place,
              fmt::format("gravity, [{:g}, {:g}, {:g}] m/s², pulls away from the surface of '{}', "
                          "whose normal is [{:g}, {:g}, {:g}]{}",
                          g.x, g.y, g.z, first.name.value, n.x, n.y, n.z,
                          spec.contacts.size() > 1 ? ", and from those of all other contacts" : ""),
              "normals point from the surface to the robot, and gravity is [0, 0, -9.81] where z "
              "points upward");
}

/// True if the file gives the reference position of kp.
bool is_placed(const ContactSpec& contact) {
  return contact.placement && contact.placement->position;
}

/// Warns of a contact that closes again after it was open, with a kp that draws it back.
void warn_of_return(const ContactSpec& contact, int index, const ContactPlan& plan,
                    const ProblemSpec& spec, Diagnostics& out) {
  if (contact.kp == 0 || is_placed(contact) || (!contact.to && swings(contact.frame.value, spec)))
    return;
  for (std::size_t p = 1; p < spec.phases.size(); ++p)
    if (plan.find(p, index) && !plan.find(p - 1, index))
      return out.warning(
          contact.baumgarte_place,
          fmt::format("kp draws the contact '{}' to where it is in the initial state, and in phase "
                      "'{}' it touches down anew",
                      contact.name.value, spec.phases[p].name.value),
          contact.to ? "give 'placement', or leave kp out"
                     : "give its frame a 'swing' that says where it lands, or leave kp out");
}

/// Checks an impulse: it needs contacts, and at least one of them must be open before.
bool check_impulse(const ProblemSpec& spec, const std::vector<std::vector<int>>& held,
                   std::size_t impulse, Diagnostics& out) {
  if (held[impulse].empty()) {
    out.error(spec.phases[impulse].name.place, "an impulse needs contacts that hit the ground");
    return false;
  }
  if (impulse == 0) return true;
  const std::vector<int>&hits = held[impulse], &before = held[impulse - 1];
  if (!std::includes(before.begin(), before.end(), hits.begin(), hits.end())) return true;
  std::string names;
  for (const int contact : hits)
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", spec.contacts[contact].name.value);
  out.error(spec.phases[impulse].knots.place,
            fmt::format("the impulse '{}' of {} has no time in the air before it: phase '{}' holds "
                        "{} already",
                        spec.phases[impulse].name.value, names, spec.phases[impulse - 1].name.value,
                        hits.size() == 1 ? "it" : "them"),
            "put a phase before it in which what touches down is not held");
  return false;
}

/// True if the terrain gives a contact its normal: its frame steps, and its axes are the world's.
bool is_on_terrain(const ContactSpec& contact, const ProblemSpec& spec) {
  return !spec.terrain.empty() && !contact.to && contact.axes == FrameAxes::world_aligned &&
         swings(contact.frame.value, spec);
}

/// Sets the normal of a contact, and projects the tangent of a planar one onto its plane.
void set_normal(const Vector3<double>& normal, Contact& contact) {
  contact.normal = normal;
  const Vector3<double> t = contact.tangent - dot(normal, contact.tangent) * normal;
  if (contact.kind == ContactKind::planar) contact.tangent = (1 / std::sqrt(squared_norm(t))) * t;
}

/// The contact in each phase: its normal, and the reference of its kp from the file, otherwise from
/// the swings.
std::vector<Contact> contacts_by_phase(const ContactSpec& spec, const Contact& contact,
                                       const ProblemSpec& problem, const Plant& plant,
                                       const std::vector<double>& initial) {
  std::vector<Contact> contacts(problem.phases.size(), contact);
  if (contact.base) return contacts;
  const SE3<double> start = placement_in_state(*plant.multibody(), initial, contact.frame);
  const std::vector<Foothold> places =
      footholds({spec.frame.value, contact.frame, start.p}, problem, plant, initial);
  for (std::size_t p = 0; p < contacts.size(); ++p) {
    if (contact.kp != 0)
      contacts[p].reference.p = is_placed(spec) ? *spec.placement->position : places[p].p;
    if (!is_on_terrain(spec, problem)) continue;
    set_normal(places[p].normal, contacts[p]);
    if (contact.kp != 0 && !(spec.placement && spec.placement->orientation))
      contacts[p].reference.R =
          rotation_matrix(orientation_at(places[p], places.front(), quaternion(start.R)));
  }
  return contacts;
}

/// Normals, and references of kp, of the contacts of a phase, as a single list.
std::vector<double> places_of(const std::vector<Contact>& held) {
  std::vector<double> places;
  for (const Contact& contact : held)
    for (int i = 0; i < 3; ++i) {
      places.push_back(contact.normal[i]);
      if (contact.kp != 0) places.push_back(contact.reference.p[i]);
    }
  return places;
}

/// The plant with these contacts.
std::shared_ptr<const System> holding_system(const PhaseSpec& phase, std::vector<Contact> held,
                                             const Plant& plant,
                                             const std::vector<double>& initial) {
  const auto system = phase.restitution
                          ? std::make_shared<MultibodySystem>(plant.multibody()->shared_robot(),
                                                              std::move(held), *phase.restitution)
                          : plant.multibody()->with_contacts(std::move(held));
  system->soften_redundant_contacts(initial.data());
  return system;
}

/// True if ẏ = λ y decays with a Runge-Kutta rule of this order; z = λ dt.
bool dies_away(std::complex<double> z, int order) {
  std::complex<double> growth = 1, term = 1;
  for (int i = 1; i <= order; ++i) growth += term *= z / static_cast<double>(i);
  return !(std::abs(growth) >= 1);
}

}  // namespace

bool is_stable(Integrator integrator, double kp, double kd, double dt) {
  using Complex = std::complex<double>;
  if (kp == 0 && kd == 0) return true;
  if (info_of(integrator).kind == StepKind::semi_implicit)
    return kd * dt >= 0 && kd * dt < 2 && 2 * kd * dt + kp * dt * dt < 4;
  const Complex root = std::sqrt(Complex(kd * kd / 4 - kp, 0));
  for (const Complex lambda : {-kd / 2 + root, -kd / 2 - root})
    if (std::abs(lambda) >= 1e-12 && !dies_away(lambda * dt, info_of(integrator).order))
      return false;
  return true;
}

std::vector<int> contacts_named(const ContactNames& names, const ProblemSpec& spec,
                                Diagnostics& out) {
  std::vector<std::string> known;
  for (const ContactSpec& contact : spec.contacts) known.push_back(contact.name.value);
  std::vector<int> chosen;
  if (names.all)
    for (std::size_t i = 0; i < known.size(); ++i) chosen.push_back(static_cast<int>(i));
  for (const Name& name : names.names) {
    const auto found = std::find(known.begin(), known.end(), name.value);
    if (found == known.end()) {
      out.error(
          name.place, fmt::format("unknown contact '{}'", name.value),
          known.empty() ? "the file has no 'contacts'" : name_hint(name.value, known, "contacts"));
      continue;
    }
    chosen.push_back(static_cast<int>(found - known.begin()));
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::optional<ContactPlan> ContactPlan::build(const ProblemSpec& spec, const Plant& plant,
                                              const std::vector<double>& initial,
                                              Integrator integrator, Diagnostics& out) {
  ContactPlan plan;
  const int errors = out.error_count();
  for (const ContactSpec& contact : spec.contacts)
    if (auto made = make_contact(contact, plant, initial, out))
      plan.contacts_.push_back(std::move(*made));
  for (const PhaseSpec& phase : spec.phases) {
    if (phase.contacts.all && spec.contacts.empty())
      out.error(
          phase.name.place,
          fmt::format("the phase '{}' holds all contacts, and the file has none", phase.name.value),
          "name them: 'contacts: {LF: {frame: lf_foot}, ...}' at the top of the file");
    plan.held_.push_back(contacts_named(phase.contacts, spec, out));
  }
  // Contacts of the last node may be those of the last phase.
  if (out.error_count() > errors) return std::nullopt;
  plan.held_.push_back(contacts_named(spec.last_contacts(), spec, out));
  if (out.error_count() > errors) return std::nullopt;

  for (std::size_t c = 0; c < spec.contacts.size(); ++c) {
    const ContactSpec& contact = spec.contacts[c];
    plan.by_phase_.push_back(contacts_by_phase(contact, plan.contacts_[c], spec, plant, initial));
    plan.contacts_[c].normal = plan.by_phase_[c].front().normal;
    warn_of_return(contact, static_cast<int>(c), plan, spec, out);
    warn_of_sole(contact, plan.contacts_[c], plant, initial, out);
  }
  warn_of_gravity(spec, out);
  if (!plan.check_loops(spec, plant, initial, out)) return std::nullopt;
  if (!plan.set_systems(spec, plant, initial, out)) return std::nullopt;
  for (std::size_t c = 0; c < spec.contacts.size(); ++c)
    warn_of_instability(spec.contacts[c], static_cast<int>(c), plan, spec, integrator, out);
  return plan;
}

bool ContactPlan::check_loops(const ProblemSpec& spec, const Plant& plant,
                              const std::vector<double>& initial, Diagnostics& out) const {
  std::vector<Contact> loops;
  std::vector<const ContactSpec*> specs;
  for (const int c : held_.front())
    if (spec.contacts[c].to && spec.contacts[c].placement) {
      loops.push_back(contacts_[c]);
      specs.push_back(&spec.contacts[c]);
    }
  if (loops.empty()) return true;
  const auto system = plant.multibody()->with_contacts(std::move(loops));
  const std::vector<double> gaps = posture_gaps(*system, {}, initial);
  const auto open = std::ranges::max_element(gaps);
  if (*open < kClosedLoop) return true;
  const ContactSpec& worst = *specs[open - gaps.begin()];
  const Contact& loop = system->contacts().contacts()[open - gaps.begin()];
  const Posture closed =
      find_posture(*system, {}, movable_joints(*system, 0, system->robot().joint_count()), initial);
  out.error(worst.name.place,
            fmt::format("'{}' and '{}' are {} in the initial state: the loop '{}' is open",
                        worst.frame.value, worst.to->value,
                        gap_text(loop, *open, *plant.multibody(), initial), worst.name.value),
            closed.found() ? "it closes with " + changed_joints(*system, initial, closed.x)
                           : "no posture was found that closes the loop");
  return false;
}

bool ContactPlan::set_systems(const ProblemSpec& spec, const Plant& plant,
                              const std::vector<double>& initial, Diagnostics& out) {
  using Structure = std::tuple<std::vector<int>, double, std::vector<double>>;
  std::map<Structure, std::shared_ptr<const System>> known;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const PhaseSpec& phase = spec.phases[p];
    if (phase.restitution && !check_impulse(spec, held_, p, out)) return false;
    std::vector<Contact> held = contacts_in(p);
    if (held.empty()) {
      systems_.push_back(plant.system_in(p));
      continue;
    }
    auto& system = known[{held_[p], phase.restitution.value_or(-1), places_of(held)}];
    if (!system) system = holding_system(phase, std::move(held), plant, initial);
    systems_.push_back(system);
  }
  return true;
}

std::vector<Contact> ContactPlan::contacts_in(std::size_t phase) const {
  std::vector<Contact> held;
  for (const int c : held_[phase]) held.push_back(by_phase_[c][phase]);
  return held;
}

std::optional<int> ContactPlan::find(std::size_t phase, int contact) const {
  const auto& held = held_[phase];
  const auto found = std::find(held.begin(), held.end(), contact);
  if (found == held.end()) return std::nullopt;
  return static_cast<int>(found - held.begin());
}

std::optional<std::vector<int>> ContactPlan::find(std::size_t phase,
                                                  const std::vector<int>& contacts) const {
  std::vector<int> indices;
  for (const int contact : contacts) {
    const auto index = find(phase, contact);
    if (!index) return std::nullopt;
    indices.push_back(*index);
  }
  return indices;
}

}  // namespace conddp
