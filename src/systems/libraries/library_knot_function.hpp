#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "systems/libraries/library_function.hpp"
#include "systems/libraries/slope_interval.hpp"

namespace conddp {

/// A compiled function f(x, u, p, t) of a knot's state, its control, constants and the time, with
/// its derivatives. Each of the four inputs is optional. Only the first output is used, a vector.
///
/// `jac_f` has the same inputs, and `out_y` for outputs y of f if it needs them. For x, u and t it
/// has outputs `jac_y_x`, where y is the name of f's first output, as in CasADi's f.jacobian(). The
/// optional `hess_f` has the same inputs and `lam`, one number for each row. It gives ∇²(lamᵀf)
/// with respect to (x, u, t), both triangles. Without it, second derivatives are differences of
/// first ones.
class LibraryKnotFunction {
 public:
  struct Sizes {
    int states, controls;
  };

  /// A mismatch between the function and its description in a file.
  struct Defect {
    enum class Part { kFunction, kStates, kControls, kParameters };
    Part part;
    std::string message;
    std::string hint;
  };

  /// Memory for a single evaluation at a time.
  struct Workspace;
  struct WorkspaceDeleter {
    void operator()(Workspace* workspace) const;
  };
  using OwnedWorkspace = std::unique_ptr<Workspace, WorkspaceDeleter>;

  /// Null if they do not match; `defect` then contains the reason.
  static std::shared_ptr<const LibraryKnotFunction> make(
      const std::shared_ptr<const SharedLibrary>& library, const std::string& name, Sizes sizes,
      const std::vector<double>& parameters, std::optional<Defect>& defect);
  ~LibraryKnotFunction();

  int rows() const { return rows_; }
  Sizes sizes() const { return sizes_; }
  bool reads_time() const { return reads_time_; }
  bool reads_control() const { return reads_control_; }
  bool has_hessian() const { return hessian_ != nullptr; }
  /// Names of the library functions that have failed in any run.
  std::vector<std::string> failed_functions() const;
  /// Size of z = (x, u, t), the point of evaluation and the variables of differentiation. t is
  /// included if the function reads the time.
  int columns() const { return sizes_.states + sizes_.controls + (reads_time_ ? 1 : 0); }
  /// The columns that each row depends on, ascending.
  const std::vector<std::vector<int>>& structure() const { return structure_; }

  OwnedWorkspace create_workspace() const;

  /// Values, rows() numbers, and the Jacobian, rows() x columns(), by columns. Evaluates lane by
  /// lane; all rows of a lane are NaN if the library's function fails there. For double, Lane and
  /// Dual<Lane>.
  ///
  /// The dual parts in `differentiate` come from `jac_f`. In `evaluate` they are confirmed by
  /// values: if differences of values contradict an entry of the Jacobian, they replace it. So
  /// comparing the two, as for any other system or residual, reveals a wrong `jac_f`.
  template <class S>
  void evaluate(const S* z, Workspace& workspace, S* f) const;
  template <class S>
  void differentiate(const S* z, Workspace& workspace, S* f, S* J) const;
  /// ∇²(weightsᵀf), columns() x columns(). For double.
  void second_derivatives(const double* z, const double* weights, Workspace& workspace,
                          double* H) const;

 private:
  class Maker;
  /// Indices that connect a function of the library to z.
  struct Binding {
    std::optional<int> x, u, p, t;  ///< inputs
  };
  /// A part of the Jacobian.
  struct JacobianPart {
    int output;
    int first;  ///< first column
  };
  /// An output of the function that is also an input of its Jacobian.
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
