#pragma once

#include <cstdint>

#include "analysis/comparison/random_instance.hpp"
#include "ocp/knot/knot_model.hpp"
#include "problem_file/model/residual_definition.hpp"
#include "problem_file/model/spec_collision.hpp"
#include "problem_file/model/spec_contact.hpp"
#include "problem_file/model/spec_cost.hpp"
#include "problem_file/model/spec_draw.hpp"
#include "problem_file/model/spec_gait.hpp"
#include "problem_file/model/spec_mesh.hpp"
#include "problem_file/model/spec_mpc.hpp"
#include "problem_file/model/spec_robot.hpp"
#include "problem_file/model/spec_solver.hpp"
#include "problem_file/model/spec_stepping.hpp"
#include "problem_file/model/spec_terminal.hpp"
#include "problem_file/model/spec_terrain.hpp"
#include "solvers/sampling/sampling_options.hpp"

namespace conddp {

/// Grid refinement at the ends of a phase. Each of the `first` first steps is `ratio` times as long
/// as the step after it, each of the `last` last steps as the step before it.
struct RefineSpec {
  int first = 0;
  int last = 0;
  double ratio = 0.5;
};

/// An initial knot without time, whose controls move the initial state.
struct ChoiceSpec {
  ComponentsSpec coordinates;                  ///< 1: may be moved
  std::optional<ComponentsSpec> lower, upper;  ///< bounds on the displacement, same units
};

/// Bounds between which the solver chooses the duration of a phase, s.
struct FreeDurationSpec {
  Place place;
  double lower = 0, upper = 0;
};

/// An instantaneous state change: x becomes the value of its expression; other states stay.
struct JumpSpec {
  Place place;
  std::vector<std::pair<Name, ExpressionText>> states;
};

/// Maximum number of knots.
inline constexpr int kMaxKnots = 1'000'000;

/// A run of knots with its settings in the file.
struct PhaseSpec {
  Name name;
  Located<int> knots;
  double dt = 0;  ///< regular step, s; 0 of an impulse
  std::optional<RefineSpec> refine;
  std::optional<FreeDurationSpec> free_duration;
  ContactNames contacts;
  /// Impulse at the contacts: one knot without time.
  std::optional<double> restitution;
  std::optional<ChoiceSpec> choice;  ///< first phase: optimize the initial state
  std::optional<JumpSpec> jump;      ///< one knot between two phases that take time
  std::optional<Name> system;        ///< if the file has several

  bool takes_no_time() const { return restitution || choice || jump; }
  /// Cost weights in this phase, which replace those of the costs.
  NamedNumbers weights;
};

/// Course of the controls between knots.
enum class ControlCourse {
  kConstant,  ///< the control at the beginning of the knot
  kLinear,    ///< linear to the control at the beginning of the next knot
};

enum class RunningCosts {
  kRate,        ///< multiplied by dt
  kIntegrated,  ///< integrated over the step with the stages of the integrator
  kSum,         ///< summed without a factor
};

struct KeyframeSpec {
  Place place;
  std::optional<Located<double>> time;  ///< s
  std::optional<KnotSpec> knot;
  StateSpec state;
};

/// Interpolation of knots between given values.
enum class Interpolation {
  kLinear,  ///< along the shortest way
  kCubic,   ///< by a natural cubic spline
};

/// Source of the initial guess.
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
  /// Rollouts around the guess given by the other keys; the best one replaces it.
  struct Sampling {
    SamplingMethod method = SamplingOptions().method;
    int samples = SamplingOptions().samples;
    Located<int> knots{6, {}};  ///< of the spline of each control
    Interpolation spline = Interpolation::kCubic;
    int rounds = SamplingOptions().rounds;
    std::uint64_t seed = SamplingOptions().seed;
  };
  std::optional<Sampling> sampling;
  /// Former solution whose multipliers are also used.
  std::optional<DataFileSpec> multipliers_file;
};

/// The supported format of problem files, the value of their key `conddp`.
inline constexpr int kProblemFormat = 1;

/// The part of a problem file that outputs and commands name. The rest becomes the built problem.
struct ProblemFacts {
  std::filesystem::path file;
  std::string sha256;  ///< of the bytes read
  Name name;
  /// With several systems, that of the first phase that takes time.
  std::optional<SystemSpec> system;
  std::vector<ContactSpec> contacts;
  std::vector<LoopSpec> loops;  ///< before the rewriting `loops`
  CollisionSpec collision;
  TerrainSpec terrain;
  std::vector<CandidateSpec> candidates;
  std::optional<SteppingSpec> stepping;  ///< present whenever candidates exist
  std::optional<MeshSpec> mesh;          ///< its factor is part of the phases
  Perturbation perturbation;
  SolverSpec solver;
  std::optional<MpcSpec> mpc;
  std::vector<DrawingSpec> drawings;
};

/// A problem file, read and checked as far as possible without its robots.
struct ProblemSpec : ProblemFacts {
  // Out of line: otherwise every source that uses a spec compiles the copy functions of all
  // members.
  ProblemSpec();
  ProblemSpec(const ProblemSpec& other);
  ProblemSpec(ProblemSpec&& other) noexcept;
  ProblemSpec& operator=(const ProblemSpec& other);
  ProblemSpec& operator=(ProblemSpec&& other) noexcept;
  ~ProblemSpec();

  std::string text;                   ///< of the file without byte-order mark
  std::string definition;             ///< canonical_definition of the document with its settings
  std::vector<std::string> settings;  ///< that replace values of the file
  std::string description;
  ExpressionNamesSpec names;  ///< available in all expressions
  std::vector<RobotSpec> robots;
  std::vector<NamedSystemSpec> systems;
  Vector3<double> gravity{0, 0, -9.81};  ///< m/s²
  StateSpec initial_state;
  std::optional<Located<Integrator>> integrator;  ///< absent: the system's default
  Located<ControlCourse> controls{ControlCourse::kConstant, {}};
  Located<RunningCosts> running_costs{RunningCosts::kRate, {}};
  std::vector<PhaseSpec> phases;
  std::optional<GaitSpec> gait;  ///< that makes the phases
  /// Path of that gait's base, with constant velocity between points; empty without a gait.
  std::vector<WayPoint> gait_way;
  std::vector<CostSpec> costs;
  std::vector<CostSpec> integrals;                ///< states that integrate their single row
  std::vector<ConstraintSpec> control_bounds;     ///< hard bounds on the control
  std::vector<ConstraintSpec> constraints;        ///< all others on running knots
  std::optional<ContactNames> terminal_contacts;  ///< absent: those of the last phase
  std::optional<TerminalLqrSpec> terminal_lqr;
  std::vector<CostSpec> terminal_costs;
  std::vector<ConstraintSpec> terminal_constraints;
  GuessSpec guess;

  const ContactNames& last_contacts() const {
    return terminal_contacts ? *terminal_contacts : phases.back().contacts;
  }
  /// The contacts with their names, in place of `all`.
  ContactNames named(const ContactNames& contacts_chosen) const;
  /// The same for terms on contacts, where `all` are those with the world.
  ContactNames named_in_term(const ContactNames& contacts_chosen, bool last_node) const;
  bool has_linear_controls() const { return controls.value == ControlCourse::kLinear; }
  /// True if running costs are multiplied by their duration.
  bool costs_are_rates() const { return running_costs.value != RunningCosts::kSum; }
  /// Null if all durations are fixed.
  const PhaseSpec* first_free_duration() const;
  /// Costs at running knots, integrals, and costs at the last node.
  std::vector<const CostSpec*> all_costs() const;
  std::vector<const ConstraintSpec*> all_constraints() const;
  bool has_jumps() const;
  int knots() const {
    int n = 0;
    for (const PhaseSpec& phase : phases) n += phase.knots.value;
    return n;
  }
  /// The first cost, integral or constraint, at running knots or the last node, whose residual has
  /// this need; null if none has it.
  const CostSpec* first_use(bool ResidualNeeds::*need) const;
  /// Name in the file of the first item that needs the previous control; empty if nothing needs it.
  std::string_view use_of_previous_control() const;
};

}  // namespace conddp
