#include <algorithm>

#include "ocp/residuals/residuals.hpp"

namespace conddp {
namespace {

class CombinationResidual : public ResidualBase<CombinationResidual> {
 public:
  CombinationResidual(int ndx, std::vector<LinearCombination> rows, bool needs_control)
      : ResidualBase(structure(ndx, rows), 0, needs_control), rows_(std::move(rows)) {}

  Reads reads() const override { return Reads::kinematics; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      r[i] = S(rows_[i].constant);
      for (const auto& term : rows_[i].terms)
        r[i] += S(term.factor) * (term.of_control ? in.u[term.index] : in.x[term.index]);
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (const LinearCombination& row : rows_)
      for (const auto& term : row.terms) *jacobian++ = S(term.factor);
  }

 private:
  /// One block per row; the columns of its terms ascend.
  static std::vector<RowBlock> structure(int ndx, std::vector<LinearCombination>& rows) {
    std::vector<RowBlock> blocks;
    for (LinearCombination& row : rows) {
      const auto column = [ndx](const LinearCombination::Term& term) {
        return term.of_control ? ndx + term.index : term.tangent;
      };
      std::sort(row.terms.begin(), row.terms.end(),
                [&](const auto& a, const auto& b) { return column(a) < column(b); });
      RowBlock& block = blocks.emplace_back(RowBlock{1, {}, true});
      for (const auto& term : row.terms) block.columns.push_back(column(term));
    }
    return blocks;
  }
  std::vector<LinearCombination> rows_;
};

}  // namespace

std::shared_ptr<const Residual> combination_residual(int ndx, std::vector<LinearCombination> rows) {
  const bool needs_control =
      std::any_of(rows.begin(), rows.end(), [](const LinearCombination& row) {
        return std::any_of(row.terms.begin(), row.terms.end(),
                           [](const auto& term) { return term.of_control; });
      });
  return std::make_shared<CombinationResidual>(ndx, std::move(rows), needs_control);
}

}  // namespace conddp
