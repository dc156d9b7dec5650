#pragma once

#include <cstdint>

#include "analysis/comparison/random_instance.hpp"
#include "ocp/knot/knot_model.hpp"
#include "problem_file/spec/residual_definition.hpp"
#include "problem_file/spec/spec_collision.hpp"
#include "problem_file/spec/spec_contact.hpp"
#include "problem_file/spec/spec_cost.hpp"
#include "problem_file/spec/spec_mesh.hpp"
#include "problem_file/spec/spec_mpc.hpp"
#include "problem_file/spec/spec_robot.hpp"
#include "problem_file/spec/spec_solver.hpp"
#include "problem_file/spec/spec_stepping.hpp"
#include "problem_file/spec/spec_terminal.hpp"

namespace conddp {

/// A grid that is finer where a phase begins or ends: each of the `first` first steps is `ratio`
/// times as long as the one after it, each of the `last` last ones as the one before it.
struct RefineSpec {
  int first = 0;
  int last = 0;
  double ratio = 0.5;
};

/// A first knot without time, whose controls move the initial state.
struct ChoiceSpec {
  ComponentsSpec coordinates;                  ///< 1: may be moved
  std::optional<ComponentsSpec> lower, upper;  ///< of the displacement, in the coordinates' units
};

/// Within which bounds a phase may last as long as the solver likes, s.
struct FreeDurationSpec {
  Place place;
  double lower = 0, upper = 0;
};

/// States that change in no time: x becomes what its expression says, others stay.
struct JumpSpec {
  Place place;
  std::vector<std::pair<Name, ExpressionText>> states;
};

/// A run of knots: all that the file says about it.
struct PhaseSpec {
  Name name;
  Located<int> knots;
  double dt = 0;  ///< regular step, s; 0 of an impulse
  std::optional<RefineSpec> refine;
  std::optional<FreeDurationSpec> free_duration;
  ContactNames contacts;
  /// Of an impulse at the contacts: one knot that takes no time.
  std::optional<double> restitution;
  std::optional<ChoiceSpec> choice;  ///< of a first phase that is one
  std::optional<JumpSpec> jump;      ///< of one knot between two phases that take time
  std::optional<Name> system;        ///< where the file has several

  bool takes_no_time() const { return restitution || choice || jump; }
  /// Weights that costs have in this phase instead of their own.
  NamedNumbers weights;
};

/// What controls are between knots.
enum class ControlCourse {
  kConstant,  ///< what they are at the knot's beginning
  kLinear,    ///< they go straight to what they are at the next knot's beginning
};

enum class RunningCosts {
  kRate,        ///< multiplied by dt
  kIntegrated,  ///< over the step, by the stages of the integrator
  kSum,         ///< added up as they are
};

struct KeyframeSpec {
  Place place;
  std::optional<Located<double>> time;  ///< s
  std::optional<Located<int>> knot;
  StateSpec state;
};

/// How knots get their values from those between which they lie.
enum class Interpolation {
  kLinear,  ///< along the shortest way
  kCubic,   ///< by a natural cubic spline
};

/// Where the first trajectory comes from.
struct GuessSpec {
  enum class States { kInitial, kInterpolate, kKeyframes, kFile };
  enum class Controls { kZero, kQuasiStatic, kConstant, kFile };
  States states = States::kInitial;
  Place states_place;
  std::vector<KeyframeSpec> keyframes;
  Interpolation interpolation = Interpolation::kLinear;  ///< between keyframes
  std::optional<DataFileSpec> states_file;
  Controls controls = Controls::kZero;
  Place controls_place;
  std::optional<ComponentsSpec> constant;
  std::optional<DataFileSpec> controls_file;
  struct Random {
    std::uint64_t seed = 0;
    double scale = 0;  ///< standard deviation, in the control's unit
  };
  std::optional<Random> random;
  /// A former solution whose multipliers are taken as well.
  std::optional<DataFileSpec> multipliers_file;
};

/// The format of problem files that is read, the value of their key `conddp`.
inline constexpr int kProblemFormat = 1;

/// A problem file, read and checked as far as it can be without its robots.
struct ProblemSpec {
  // Not inline: each of the many sources that have one would compile the copies of all that is in
  // it.
  ProblemSpec();
  ProblemSpec(const ProblemSpec& other);
  ProblemSpec(ProblemSpec&& other) noexcept;
  ProblemSpec& operator=(const ProblemSpec& other);
  ProblemSpec& operator=(ProblemSpec&& other) noexcept;
  ~ProblemSpec();

  std::filesystem::path file;
  std::string text;                   ///< of the file, without a byte-order mark
  std::string sha256;                 ///< of the bytes that were read
  std::string definition;             ///< canonical_definition of the document with its settings
  std::vector<std::string> settings;  ///< that replaced values of the file
  Name name;
  std::string description;
  ExpressionNamesSpec names;  ///< that all expressions know
  std::vector<RobotSpec> robots;
  std::optional<SystemSpec> system;  ///< of several that of the first phase that takes time
  std::vector<NamedSystemSpec> systems;
  Vector3<double> gravity{0, 0, -9.81};  ///< m/s²
  StateSpec initial_state;
  std::optional<Located<Integrator>> integrator;  ///< absent: the system's usual one
  Located<ControlCourse> controls{ControlCourse::kConstant, {}};
  Located<RunningCosts> running_costs{RunningCosts::kRate, {}};
  std::vector<ContactSpec> contacts;
  CollisionSpec collision;
  std::vector<CandidateSpec> candidates;
  std::optional<SteppingSpec> stepping;  ///< there wherever candidates are
  std::optional<MeshSpec> mesh;          ///< its factor is part of the phases
  std::vector<PhaseSpec> phases;
  std::vector<GaitCommand> gait_commands;  ///< of the gait that made the phases
  /// The way of that gait's base, on which it moves evenly from point to point; empty: no gait.
  std::vector<WayPoint> gait_way;
  std::vector<CostSpec> costs;
  std::vector<CostSpec> integrals;  ///< numbers of the state that grow with their one row
  std::vector<ControlBoundsSpec> control_bounds;
  std::vector<ConstraintSpec> constraints;        ///< all others on running knots
  std::optional<ContactNames> terminal_contacts;  ///< absent: those of the last phase
  std::optional<TerminalLqrSpec> terminal_lqr;
  std::vector<CostSpec> terminal_costs;
  std::vector<ConstraintSpec> terminal_constraints;
  GuessSpec guess;
  Perturbation perturbation;
  SolverSpec solver;
  std::optional<MpcSpec> mpc;

  const ContactNames& last_contacts() const {
    return terminal_contacts ? *terminal_contacts : phases.back().contacts;
  }
  bool has_linear_controls() const { return controls.value == ControlCourse::kLinear; }
  /// Whether running costs are multiplied by the time that they last.
  bool costs_are_rates() const { return running_costs.value != RunningCosts::kSum; }
  /// Null if all durations are fixed.
  const PhaseSpec* first_free_duration() const;
  /// Those at running knots, integrals, and those at the last node.
  std::vector<const CostSpec*> all_costs() const;
  std::vector<const ConstraintSpec*> all_constraints() const;
  bool has_jumps() const;
  /// Whether it runs compiled code that the file names.
  bool runs_code() const;
  int knots() const {
    int n = 0;
    for (const PhaseSpec& phase : phases) n += phase.knots.value;
    return n;
  }
  /// The first cost, integral or constraint, at running knots or the last node, whose residual
  /// needs this; null if there is none.
  const CostSpec* first_use(bool ResidualNeeds::*need) const;
  /// What first needs the previous control, by its name in the file; empty: nothing.
  std::string_view use_of_previous_control() const;
};

}  // namespace conddp
