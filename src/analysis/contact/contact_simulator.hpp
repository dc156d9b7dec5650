#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "analysis/contact/linear_complementarity.hpp"
#include "analysis/contact/stepping_equations.hpp"

namespace conddp {

/// Outcome of a step of the simulator.
enum class StepStatus {
  solved,      ///< all equations and complementarities hold to the tolerance
  unsolved,    ///< iteration limit reached; the best step found is returned
  no_contact,  ///< the linearized contact problem could not be solved
  not_finite,  ///< a number is not finite; the state before the step is returned
};
std::string_view to_string(StepStatus status);

struct ContactStep {
  StepStatus status = StepStatus::solved;
  Eigen::VectorXd q, v;  ///< state at the end
  StepForces forces;
  int iterations = 0;
  double residual = 0;  ///< largest residual of all equations, scaled as below
};

struct ContactSimulatorOptions {
  /// Bound on residual impulses, divided by h m g. It also bounds the smaller one of each
  /// complementary pair of velocities (m/s, gaps divided by h) and impulses divided by h m g.
  double tolerance = 1e-10;
  int max_iterations = 40;
};

/// Takes one time step after another with contacts, stops and dry friction. Each implicit step of
/// ImplicitContacts is solved anew, without knowledge of any plan.
///
/// Newton's method for generalized equations (Josephy) linearizes dynamics, gaps and contact
/// velocities at the iterate by dual numbers. Pivoting solves the resulting linear complementarity
/// problem, until the step itself satisfies all equations. If pivoting ends on a ray, the
/// derivatives of the force directions are omitted; the problem then has a solution by Anitescu and
/// Potra (1997). For a friction cone in space, the pyramid is turned at every iteration until one
/// of its edges lies along slip and force. Near the solution, friction opposes the slip itself, so
/// the answer is that of the cone. If all this fails, impulses are found by sweeps (sweep_impulses)
/// within Newton's iterations. This happens if many contacts of one body share its load and slide.
class ContactSimulator {
 public:
  explicit ContactSimulator(const ContactPlant& plant, ContactSimulatorOptions options = {});
  ContactSimulator(const ContactSimulator&) = delete;

  ContactStep step(const StepStart& start);
  /// Prefers the solution in the contact mode of `near`: the closed contacts, the slipping ones and
  /// their slip directions. Without such a solution, steps as above. `near` gives v and forces.
  ContactStep step(const StepStart& start, const ContactStep& near);

 private:
  struct Response;
  struct Pivoted;
  struct ImpulseRows;
  /// Progress of Newton's method: another iteration may gain something, nothing is left to gain, or
  /// a number is not finite.
  enum class Progress { goes_on, ends, lost };
  /// Residuals below this are rounding.
  static constexpr double kRounding = 1e-14;

  void linearize(const StepStart& start, const ContactStep& at, bool with_forces);
  ContactPairs assemble(const StepStart& start, const ContactStep& at, bool with_slopes) const;
  void add_contact(std::size_t candidate, const StepStart& start, const ContactStep& at,
                   bool with_slopes, ContactPairs& pairs) const;
  /// True if the friction of a candidate follows its normal force, against its heading.
  bool keeps_slipping(std::size_t candidate) const { return !heading_.col(candidate).isZero(0); }
  Eigen::MatrixXd pyramid_turn(std::size_t candidate, int tangents) const;
  double angle_off(std::size_t candidate, const Eigen::Vector2d& slip) const;
  StepForces forces(const Eigen::VectorXd& z, double h) const;
  double turn_pyramids(const StepStart& start, const ContactStep& at, double residual);
  Eigen::MatrixXd turning_slope(const StepStart& start, const ContactStep& at) const;
  std::optional<Response> respond(const StepStart& start, const ContactStep& at,
                                  bool with_slopes) const;
  Progress advance(const StepStart& start, const Eigen::VectorXd& z, const Response& response,
                   ContactStep& at, ContactStep& best);
  ContactStep step_by_pivoting(const StepStart& start);
  Pivoted pivot(const StepStart& start, const ContactStep& at, bool careful);
  std::vector<int> find_active(const StepStart& start, const ContactStep& at) const;
  ContactStep step_in_mode(const StepStart& start, const ContactStep& near);
  void move(const StepStart& start, const Eigen::VectorXd& z, const Eigen::VectorXd& dv,
            ContactStep& at);
  Eigen::VectorXd impulses(const StepForces& forces, const Eigen::VectorXd& v, double h) const;
  ContactStep step_by_sweeps(const StepStart& start, const ContactStep& from);
  ImpulseRows impulse_rows(const StepStart& start, const ContactStep& at) const;
  void add_candidate(std::size_t candidate, const ContactStep& at, ImpulseRows& rows) const;
  void add_stop(std::size_t stop, const StepStart& start, const ContactStep& at,
                ImpulseRows& rows) const;
  StepForces forces_of_rows(const Eigen::VectorXd& p, double h) const;
  double residual(const StepStart& start, const ContactStep& at, const Eigen::VectorXd& z) const;

  const ContactPlant plant_;
  ContactSimulatorOptions options_;
  SteppingEquations<Dual<double>> slopes_;
  int pairs_ = 0;
  Eigen::VectorXd pyramid_;   ///< angle of each candidate's first tangent
  Eigen::Matrix2Xd heading_;  ///< slip direction of contacts that keep slipping, else zero
  Eigen::VectorXd impulse_;   ///< free impulse at the iterate
  Eigen::MatrixXd A_;         ///< its slope with respect to v, minus that of the forces
  /// Candidates at the iterate: the gap; the rows; slopes of gap / h and of velocities.
  std::vector<double> gap_;
  std::vector<Eigen::Matrix3Xd> rows_, slope_;
};

}  // namespace conddp
