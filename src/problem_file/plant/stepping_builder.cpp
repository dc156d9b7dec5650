#include "problem_file/plant/stepping_builder.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "ocp/residuals/stepping_residual.hpp"
#include "problem_file/plant/joint_values.hpp"

namespace conddp {
namespace {

constexpr const char* kEquations = "stepping";
constexpr const char* kPairs = "complementarity";
constexpr const char* kRegularization = "contact_regularization";

/// Overlaps within the rounding of placements, m.
constexpr double kRoundedOverlap = 1e-3;
/// Tolerance on the out-of-plane component of a normal for planar motion.
constexpr double kOutOfPlane = 1e-6;

std::optional<ContactCandidate> build_candidate(const CandidateSpec& spec, const Plant& plant,
                                                Diagnostics& out) {
  const auto frame = find_frame(plant.robot(), spec.frame, "", out);
  const auto other = spec.against.frame ? find_frame(plant.robot(), *spec.against.frame, "", out)
                                        : std::optional(-1);
  if (!frame || !other) return std::nullopt;
  const auto body = [&](int f) { return f < 0 ? -1 : plant.robot().frames[f].joint; };
  if (body(*frame) == body(*other)) {
    out.error(
        spec.against.frame ? spec.against.frame->place : spec.frame.place,
        fmt::format("'{}' and the surface that it may touch do not move relative to each other",
                    spec.name.value));
    return std::nullopt;
  }
  return ContactCandidate{.name = spec.name.value,
                          .sphere = {*frame, spec.point, spec.radius},
                          .against = touched_form(spec.against, *other),
                          .friction = spec.friction,
                          .stiffness = spec.stiffness};
}

/// Friction of a planar motion acts along the plane's tangent, so surfaces must be perpendicular to
/// the plane.
void check_plane(const CandidateSpec& spec, const SteppingSpec& stepping, Diagnostics& out) {
  const auto* half_space = std::get_if<HalfSpaceSpec>(&spec.against.form);
  if (!stepping.plane || half_space == nullptr || spec.against.frame ||
      std::abs(dot(*stepping.plane, half_space->normal)) <= kOutOfPlane)
    return;
  out.error(stepping.place,
            fmt::format("'{}' touches a surface that is not upright to the plane of the motion",
                        spec.name.value),
            "'plane' is the direction in which nothing moves, [0, 1, 0] for motions in x and z");
}

/// Adds stops: the limits in `joint_limits`, and with `all_limits` the URDF limits of every joint.
void build_stops(const ProblemSpec& spec, const Plant& plant, ImplicitContacts& contacts,
                 Diagnostics& out) {
  const RobotModel& robot = plant.robot();
  for (int j = 0; spec.stepping->all_limits && j < robot.joint_count(); ++j)
    contacts.stops.push_back({j, robot.joints[j].lower, robot.joints[j].upper});
  for (const auto& [joint, limits] : values_of_joints(robot, spec.stepping->joint_limits, "", out))
    contacts.stops.push_back({joint, limits[0], limits[1]});
}

/// Reports unsupported terms, and terms with reserved names.
void check_terms(const ProblemSpec& spec, Diagnostics& out) {
  for (const CostSpec* cost : spec.all_costs())
    if (cost->name.value == kRegularization)
      out.error(cost->name.place,
                fmt::format("'{}' is the name of a built-in cost of contact-implicit problems",
                            kRegularization));
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (const Name& name = constraint->function.name;
        name.value == kEquations || name.value == kPairs)
      out.error(
          name.place,
          fmt::format("'{}' is the name of a built-in constraint of contact-implicit problems",
                      name.value));
}

void check_frozen_keys(const ProblemSpec& spec, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (phase.restitution || phase.contacts.any())
      out.error(phase.name.place, "contacts of a contact-implicit problem are not named by phases",
                "leave 'contacts' and 'impulse' out");
  if (spec.integrator && spec.integrator->value != Integrator::semi_implicit_euler)
    out.error(spec.integrator->place,
              "contact-implicit problems have a stepping scheme of their own",
              "leave 'integrator' out, or write 'integrator: semi_implicit_euler'");
  check_terms(spec, out);
}

}  // namespace

decltype(ContactCandidate::against) touched_form(const TouchedSpec& touched, int frame) {
  if (const auto* half_space = std::get_if<HalfSpaceSpec>(&touched.form))
    return ContactHalfSpace{frame, half_space->normal, dot(half_space->normal, half_space->point)};
  if (const auto* sphere = std::get_if<SphereSpec>(&touched.form))
    return ContactSphere{frame, sphere->center, sphere->radius};
  const auto& box = std::get<BoxSpec>(touched.form);
  return ContactBox{frame, box.placement.placement(), 0.5 * box.size};
}

std::shared_ptr<const SteppingSystem> build_stepping(const ProblemSpec& spec, const Plant& plant,
                                                     Diagnostics& out) {
  const int errors = out.error_count();
  check_frozen_keys(spec, out);
  ImplicitContacts contacts{.scheme = spec.stepping->scheme,
                            .friction = spec.stepping->friction,
                            .plane = spec.stepping->plane};
  for (const CandidateSpec& candidate : spec.candidates) {
    check_plane(candidate, *spec.stepping, out);
    if (auto built = build_candidate(candidate, plant, out))
      contacts.candidates.push_back(std::move(*built));
  }
  build_stops(spec, plant, contacts, out);
  for (const auto& [joint, limit] :
       values_of_joints(plant.robot(), spec.stepping->joint_friction, "", out))
    contacts.frictions.push_back({joint, limit});
  if (out.error_count() > errors) return nullptr;
  try {
    return std::make_shared<SteppingSystem>(plant.multibody(), std::move(contacts));
  } catch (const std::invalid_argument& e) {
    out.error(spec.stepping->place, e.what());
    return nullptr;
  }
}

void warn_of_overlaps(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& state,
                      Diagnostics& out) {
  const auto data = plant.multibody()->create_data(double{});
  plant.multibody()->update_kinematics(state.data(), *data);
  const RobotData<double>& placements =
      static_cast<const MultibodySystem::Data<double>&>(*data).robot;
  const ImplicitContacts& contacts = plant.stepping()->contacts();
  for (const ContactCandidate& candidate : contacts.candidates) {
    if (candidate.stiffness) continue;
    const CandidateGeometry geometry(plant.robot(), candidate, contacts.plane);
    auto rows = geometry.create_rows<double>();
    geometry.evaluate(placements, rows);
    if (rows.gap >= -kRoundedOverlap) continue;
    out.warning(
        spec.initial_state.place,
        fmt::format("the initial state has '{}' {:.3g} m inside a surface that it may only touch",
                    candidate.name, -rows.gap),
        "the first step would throw them apart");
  }
}

void add_stepping_terms(const std::shared_ptr<const SteppingSystem>& system, KnotModel& model) {
  model.add_constraint(
      make_constraint(kEquations, stepping_residual(system, model.ndx(), model.step().duration()),
                      ConstraintKind::bounds));
  model.add_constraint(make_constraint(kPairs, stepping_pairs_residual(*system, model.ndx()),
                                       ConstraintKind::complementarity));
  const SteppingLayout& w = system->layout();
  std::vector<int> forces;
  const auto add_friction = [&](const FrictionIndices& f) {
    if (f.count == 0) return;
    forces.insert(forces.end(), f.force.begin(), f.force.begin() + f.count);
    forces.push_back(f.gamma);
  };
  for (const SteppingLayout::Candidate& c : w.candidates) {
    forces.push_back(c.force);
    add_friction(c.friction);
    if (!c.cone.present) continue;
    // Includes the share of friction: without force and slip no other term determines it.
    forces.insert(forces.end(), c.cone.force.begin(), c.cone.force.end());
    forces.insert(forces.end(), c.cone.use.begin(), c.cone.use.end());
    forces.push_back(c.cone.speed);
  }
  for (const SteppingLayout::Stop& stop : w.stops) forces.push_back(stop.force);
  for (const FrictionIndices& f : w.frictions) add_friction(f);
  model.add_cost(kRegularization, chosen_controls_residual(model.ndx(), forces), {});
}

void write_stepping_parameters(const KnotModel& model, double dt, double regularization,
                               double* parameters) {
  const auto& constraints = model.constraints();
  const ConstraintTerm& equations = constraints[constraints.size() - 2];
  parameters[equations.parameters] = dt;
  std::fill_n(parameters + equations.lower(), 2 * equations.rows, 0.0);
  parameters[equations.active()] = parameters[constraints.back().active()] = 1;
  parameters[model.costs().back().weight] = regularization;
}

}  // namespace conddp
