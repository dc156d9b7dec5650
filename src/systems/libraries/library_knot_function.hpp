#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "systems/libraries/library_function.hpp"
#include "systems/libraries/slope_interval.hpp"

namespace conddp {

/// A compiled function f(x, u, p, t) of a knot's state, its control, constants and the time, with
/// its derivatives. All of the four inputs may be absent. Its first output counts, a vector.
///
/// `jac_f` has the same inputs, `out_y` of outputs y of f if it needs them, and, for x, u and t,
/// outputs `jac_y_x`, where y is the name of f's first output: what CasADi's f.jacobian() gives.
/// `hess_f`, if there is one, has the same inputs and `lam`, one number for each row, and gives
/// ∇²(lamᵀf) with respect to (x, u, t), both of its triangles. Without it second derivatives are
/// differences of first ones.
class LibraryKnotFunction {
 public:
  struct Sizes {
    int states, controls;
  };

  /// Where the function and what a file says of it do not fit.
  struct Defect {
    enum class Part { kFunction, kStates, kControls, kParameters };
    Part part;
    std::string message;
    std::string hint;
  };

  /// Memory of its evaluations, one at a time.
  struct Workspace;
  struct WorkspaceDeleter {
    void operator()(Workspace* workspace) const;
  };
  using OwnedWorkspace = std::unique_ptr<Workspace, WorkspaceDeleter>;

  /// Null, with the reason in `defect`, where they do not fit.
  static std::shared_ptr<const LibraryKnotFunction> make(
      const std::shared_ptr<const SharedLibrary>& library, const std::string& name, Sizes sizes,
      const std::vector<double>& parameters, std::optional<Defect>& defect);
  ~LibraryKnotFunction();

  int rows() const { return rows_; }
  Sizes sizes() const { return sizes_; }
  bool reads_time() const { return reads_time_; }
  bool reads_control() const { return reads_control_; }
  bool has_hessian() const { return hessian_ != nullptr; }
  /// The names of the library's functions of which a run has failed so far.
  std::vector<std::string> failed_functions() const;
  /// Of z = (x, u, t), t where the time is read: what it is evaluated at and differentiated by.
  int columns() const { return sizes_.states + sizes_.controls + (reads_time_ ? 1 : 0); }
  /// Of each row the columns on which it depends, ascending.
  const std::vector<std::vector<int>>& structure() const { return structure_; }

  OwnedWorkspace create_workspace() const;

  /// Values, rows() numbers; and the Jacobian, rows() x columns(), by columns. Lane by lane; NaN in
  /// all rows of a lane in which the library's function fails. For double, Lane and Dual<Lane>.
  ///
  /// Dual numbers of `differentiate` rest on `jac_f`, those of `evaluate` on values alone: an entry
  /// of the Jacobian that differences of values contradict is there what differences give. So a
  /// comparison of the two, as of any other system or residual, finds a `jac_f` that is wrong.
  template <class S>
  void evaluate(const S* z, Workspace& workspace, S* f) const;
  template <class S>
  void differentiate(const S* z, Workspace& workspace, S* f, S* J) const;
  /// ∇²(weightsᵀf), columns() x columns(). For double.
  void second_derivatives(const double* z, const double* weights, Workspace& workspace,
                          double* H) const;

 private:
  class Maker;
  /// How a function of the library and z go together.
  struct Binding {
    std::optional<int> x, u, p, t;  ///< inputs
  };
  /// A part of the Jacobian.
  struct JacobianPart {
    int output;
    int first;  ///< column
  };
  /// An output of the function that is an input of its Jacobian.
  struct NominalOutput {
    int input, output;
  };

  LibraryKnotFunction() = default;
  void set_inputs(const Binding& binding, const double* z, LibraryFunction::Workspace& out) const;
  void values_at(const double* z, Workspace& workspace, double* f) const;
  void jacobian_at(const double* z, Workspace& workspace, double* J) const;
  bool set_nominal_outputs(const double* z, Workspace& workspace) const;
  void confirmed_jacobian(const double* z, Workspace& workspace) const;
  void confirm_column(const double* z, int column, double largest, Workspace& workspace) const;
  void slopes_beside(const double* z, int column, double step, Workspace& workspace,
                     std::vector<double>& slopes) const;
  void measure_column(const double* z, int column, double h, int step, Workspace& workspace) const;
  SlopeInterval one_sided_slopes(const double* z, int column, int row, double step, double slope,
                                 Workspace& workspace) const;
  void jacobian_along(const double* z, const double* direction, Workspace& workspace,
                      double* dJ) const;
  void jacobian_by_differences(const double* z, const double* direction, Workspace& workspace,
                               double* dJ) const;
  void differentiate_centrally(const double* z, const double* direction, double step,
                               Workspace& workspace, double* dJ) const;
  void hessian_at(const double* z, const double* weights, Workspace& workspace, double* H) const;

  std::unique_ptr<LibraryFunction> values_, jacobian_, hessian_;
  Binding values_binding_, jacobian_binding_, hessian_binding_;
  int weights_input_ = -1;  ///< of the Hessian
  std::vector<JacobianPart> jacobian_parts_;
  std::vector<NominalOutput> nominal_outputs_;
  Sizes sizes_{};
  int rows_ = 0;
  bool reads_time_ = false, reads_control_ = false;
  std::vector<double> parameters_;
  std::vector<std::vector<int>> structure_;
};

}  // namespace conddp
