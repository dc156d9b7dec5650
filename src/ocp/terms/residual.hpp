#pragma once

#include <memory>
#include <string>
#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// Inputs of a residual at a knot: state, control at the knot's beginning (null at a node without
/// control), the residual's own parameters (references), and the system's data at (x, u). The data
/// are evaluated and, for `differentiate`, differentiated; their scratch members may be written.
template <class S>
struct ResidualInput {
  const S* x;
  const S* u;
  const S* parameters;
  SystemData<S>& system;
  /// The knot's own control vector if controls are linear: it begins with the control at the knot's
  /// end. Null if u is that vector.
  const S* end = nullptr;
};

/// Rows of a residual that depend on the same variables: ascending indices into z = (tangent at x,
/// u).
struct RowBlock {
  int rows;
  std::vector<int> columns;
  bool affine = false;  ///< true if their Jacobian is constant
  /// Columns, ascending, among which the rows are affine: their second derivatives vanish.
  std::vector<int> affine_columns = {};
};

/// System data that a residual reads: the output of update_kinematics, also the contact forces and
/// their derivatives, or everything.
enum class Reads { kinematics, forces, everything };

class Residual;

/// A residual whose rows are constant linear functions of another residual with fewer rows, r =
/// A·of.
struct LinearImage {
  std::shared_ptr<const Residual> of;  ///< without parameters
  std::vector<double> A;               ///< rows of r x rows of `of`, by rows
};

/// A vector function r(x, u; parameters) of a knot. An activation makes it a cost, a set makes it a
/// constraint. Immutable; derive through ResidualBase.
class Residual {
 public:
  virtual ~Residual() = default;

  int size() const { return size_; }
  /// Number of parameters (its reference) that a knot provides.
  int parameter_count() const { return parameter_count_; }
  /// True if the residual is meaningful only at nodes with a control.
  bool needs_control() const { return needs_control_; }
  virtual Reads reads() const { return Reads::everything; }
  /// The structure of its Jacobian: blocks of rows in order.
  const std::vector<RowBlock>& blocks() const { return blocks_; }
  /// This residual as a linear image of another one, or null. Costs use it to form their Hessians.
  virtual const LinearImage* linear_image() const { return nullptr; }
  /// Table readings of its rows at a node; u is null at a node without control.
  virtual std::vector<TableReading> table_readings(const double* /*x*/, const double* /*u*/,
                                                   const double* /*parameters*/) const {
    return {};
  }
  /// Like System::failed_functions and System::has_claimed_hessian.
  virtual std::vector<std::string> failed_functions() const { return {}; }
  virtual bool has_claimed_hessian() const { return false; }
  /// Number of entries in the packed Jacobian: the blocks in order, each by columns.
  int jacobian_size() const {
    int n = 0;
    for (const RowBlock& b : blocks_) n += b.rows * static_cast<int>(b.columns.size());
    return n;
  }

  /// `evaluate` writes size() numbers; `differentiate` writes the values and the packed Jacobian.
#define CONDDP_DECLARE(S)                                            \
  virtual void evaluate(const ResidualInput<S>& in, S* r) const = 0; \
  virtual void differentiate(const ResidualInput<S>& in, S* r, S* jacobian) const = 0;
  CONDDP_FOR_EACH_SCALAR(CONDDP_DECLARE)
#undef CONDDP_DECLARE

 protected:
  Residual(std::vector<RowBlock> blocks, int parameter_count, bool needs_control)
      : blocks_(std::move(blocks)),
        parameter_count_(parameter_count),
        needs_control_(needs_control) {
    for (const RowBlock& b : blocks_) size_ += b.rows;
  }

 private:
  std::vector<RowBlock> blocks_;
  int size_ = 0;
  int parameter_count_;
  bool needs_control_;
};

/// Implements Residual's methods by `Derived::evaluate_as<S>` and `Derived::differentiate_as<S>`.
template <class Derived>
class ResidualBase : public Residual {
 public:
  using Residual::Residual;
#define CONDDP_OVERRIDE(S)                                                            \
  void evaluate(const ResidualInput<S>& in, S* r) const override {                    \
    static_cast<const Derived&>(*this).template evaluate_as<S>(in, r);                \
  }                                                                                   \
  void differentiate(const ResidualInput<S>& in, S* r, S* jacobian) const override {  \
    static_cast<const Derived&>(*this).template differentiate_as<S>(in, r, jacobian); \
  }
  CONDDP_FOR_EACH_SCALAR(CONDDP_OVERRIDE)
#undef CONDDP_OVERRIDE
};

/// The columns first, first + 1, ..., first + count − 1.
std::vector<int> column_range(int first, int count);

/// Throws std::invalid_argument if a residual needs a control or columns of z that a node lacks.
void check_fit(const std::string& what, const Residual& residual, bool has_control, int nz);

/// Sorts the columns of single rows, removes duplicates, and merges consecutive rows with the same
/// columns into blocks.
std::vector<RowBlock> joined_blocks(std::vector<RowBlock> rows);

/// The block of a residual that contains a row, and the row's place there.
struct PackedRow {
  const RowBlock* block;
  int first;  ///< its first derivative among those of the residual; stride to the next column:
              ///< block->rows

  /// Place of its derivative by one of the block's columns.
  int place(int column) const;
};
std::vector<PackedRow> packed_rows(const Residual& residual);

/// Residuals are shared by threads and own no mutable memory. Temporary numbers of a pass are on
/// the stack, at most this many.
inline constexpr int kMostStackNumbers = 4096;

/// Calls run(numbers) with at least `count` uninitialized numbers.
template <class S, class Run>
void with_stack_numbers(int count, Run&& run) {
  constexpr int kFew = 128, kMany = 1024;
  if (count <= kFew) {
    S numbers[kFew];
    run(numbers);
  } else if (count <= kMany) {
    S numbers[kMany];
    run(numbers);
  } else {
    S numbers[kMostStackNumbers];
    run(numbers);
  }
}

}  // namespace conddp
