#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "analysis/contact/contact_pairs.hpp"
#include "analysis/contact/stepping_equations.hpp"

namespace conddp {

/// How a step of the simulator ended.
enum class StepStatus {
  solved,      ///< all equations and complementarities hold to the tolerance
  unsolved,    ///< the iterations ran out; the best step found is given
  no_contact,  ///< the linearised contact problem has no solution
  not_finite,  ///< a number is not finite: the step is that before it
};
std::string_view to_string(StepStatus status);

struct ContactStep {
  StepStatus status = StepStatus::solved;
  Eigen::VectorXd q, v;  ///< at the end
  StepForces forces;
  int iterations = 0;
  double residual = 0;  ///< of all equations, scaled as below
};

struct ContactSimulatorOptions {
  /// Of impulses, divided by h m g; of the smaller of each complementary pair of velocities (m/s,
  /// gaps divided by h) and impulses divided by h m g.
  double tolerance = 1e-10;
  int max_iterations = 40;
};

/// Takes one step of time after the other with contacts, stops and dry friction: the implicit step
/// of ImplicitContacts, solved anew for every step and without knowledge of any plan.
///
/// Newton's method for generalised equations (Josephy): dynamics, gaps and velocities at the
/// contacts are linearised at the iterate by dual numbers and the resulting linear complementarity
/// problem is solved by pivoting, until the step itself satisfies all of it. Where pivoting ends on
/// a ray, the derivatives of forces' directions are left out (then the problem has a solution by
/// Anitescu and Potra 1997). With a friction cone in space the pyramid is turned at every iteration
/// until one of its edges lies along slip and force, and near the solution friction is put against
/// the slip itself: so its answer is that of the cone. Where all that fails, as it does where many
/// contacts of one body share its load and slide, impulses are found by sweeps (sweep_impulses)
/// inside of Newton's iterations.
class ContactSimulator {
 public:
  explicit ContactSimulator(const ContactPlant& plant, ContactSimulatorOptions options = {});
  ContactSimulator(const ContactSimulator&) = delete;

  ContactStep step(const StepStart& start);
  /// Of several solutions of a step the one in the mode of `near` (which contacts are closed, which
  /// of those slip, and where to), if there is one; else as above. `near` gives v and forces.
  ContactStep step(const StepStart& start, const ContactStep& near);

 private:
  struct Response;
  struct Pivoted;
  struct ImpulseRows;
  /// Of Newton's method: whether there is something to gain from another iteration, or a number is
  /// not finite.
  enum class Progress { goes_on, ends, lost };
  /// Residuals below are rounding.
  static constexpr double kRounding = 1e-14;

  void linearize(const StepStart& start, const ContactStep& at, bool with_forces);
  ContactPairs assemble(const StepStart& start, const ContactStep& at, bool with_slopes) const;
  void add_contact(std::size_t candidate, const StepStart& start, const ContactStep& at,
                   bool with_slopes, ContactPairs& pairs) const;
  /// Whether the friction of a candidate goes with its normal force, against its heading.
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
  Eigen::VectorXd pyramid_;   ///< angle by which each candidate's first tangent is turned
  Eigen::Matrix2Xd heading_;  ///< of the slip of those that keep to slipping, else zero
  Eigen::VectorXd impulse_;   ///< free impulse at the iterate
  Eigen::MatrixXd A_;         ///< its slope with respect to v, less that of the forces
  /// Of each candidate at the iterate: the gap; the rows; slopes of the gap over h and of
  /// velocities.
  std::vector<double> gap_;
  std::vector<Eigen::Matrix3Xd> rows_, slope_;
};

}  // namespace conddp
