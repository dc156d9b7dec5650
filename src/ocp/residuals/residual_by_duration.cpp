#include "ocp/residuals/residual_by_duration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ocp/terms/residual.hpp"

namespace conddp {
namespace {

/// The block of a constraint that contains a row, and its place there.
struct RowPlace {
  const RowBlock* block;
  int first;  ///< first derivative of the block among those of the constraint
  int row;    ///< within the block
};

RowPlace place_of(const ConstraintTerm& term, int row) {
  RowPlace place{term.blocks.data(), 0, row};
  while (place.row >= place.block->rows) {
    place.row -= place.block->rows;
    place.first += place.block->rows * static_cast<int>(place.block->columns.size());
    ++place.block;
  }
  return place;
}

/// Columns of each row, including the duration.
std::vector<RowBlock> structure(const ConstraintTerm& term, const std::vector<int>& rows,
                                int duration) {
  std::vector<RowBlock> blocks;
  for (const int row : rows) {
    std::vector<int> columns = place_of(term, row).block->columns;
    const auto at = std::ranges::lower_bound(columns, duration);
    if (at == columns.end() || *at != duration) columns.insert(at, duration);
    blocks.push_back({1, std::move(columns)});
  }
  return blocks;
}

/// T/written (g − b) of rows of a constraint. Parameters: those of its residual, then b.
class ResidualByDuration : public ResidualBase<ResidualByDuration> {
 public:
  ResidualByDuration(const ConstraintTerm& term, std::vector<int> rows,
                     const DurationColumn& duration)
      : ResidualBase(structure(term, rows, duration.tangent),
                     term.residual->parameter_count() + static_cast<int>(rows.size()),
                     term.residual->needs_control()),
        term_(term),
        rows_(std::move(rows)),
        duration_(duration) {
    int entry = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const RowPlace place = place_of(term_, rows_[i]);
      const std::vector<int>& columns = blocks()[i].columns;
      const auto in_row = [&](int column) {
        return entry +
               static_cast<int>(std::ranges::lower_bound(columns, column) - columns.begin());
      };
      for (std::size_t c = 0; c < place.block->columns.size(); ++c)
        products_.push_back({in_row(place.block->columns[c]),
                             place.first + static_cast<int>(c) * place.block->rows + place.row});
      by_duration_.push_back(in_row(duration_.tangent));
      entry += static_cast<int>(columns.size());
    }
  }

  Reads reads() const override { return term_.residual->reads(); }
  std::vector<TableReading> table_readings(const double* x, const double* u,
                                           const double* parameters) const override {
    return term_.residual->table_readings(x, u, parameters);
  }
  std::vector<std::string> failed_functions() const override {
    return term_.residual->failed_functions();
  }
  bool has_claimed_hessian() const override { return term_.residual->has_claimed_hessian(); }

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const int n = term_.residual->size();
    with_stack_numbers<S>(n + term_.rows, [&](S* inner) {
      S* g = inner + n;
      term_.residual->evaluate(in, inner);
      form_value(term_, inner, g);
      write_rows(in, g, r);
    });
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    const int n = term_.residual->size(), entries = term_.residual->jacobian_size();
    with_stack_numbers<S>(n + term_.rows + entries + term_.jacobian_size(), [&](S* inner) {
      S *g = inner + n, *of_residual = g + term_.rows, *of_term = of_residual + entries;
      term_.residual->differentiate(in, inner, of_residual);
      const S norm = form_value(term_, inner, g);
      form_jacobian(term_, inner, norm, of_residual, of_term);
      write_rows(in, g, r);
      std::fill_n(jacobian, jacobian_size(), S(0.0));
      const S share = share_at(in);
      for (const Product& product : products_)
        jacobian[product.entry] += share * of_term[product.inner];
      for (std::size_t i = 0; i < rows_.size(); ++i)
        jacobian[by_duration_[i]] += (g[rows_[i]] - offset(in, i)) * S(1 / duration_.written);
    });
  }

 private:
  struct Product {
    int entry;  ///< in this residual's Jacobian
    int inner;  ///< in the constraint's Jacobian
  };

  template <class S>
  S share_at(const ResidualInput<S>& in) const {
    return in.x[duration_.state] * S(1 / duration_.written);
  }
  template <class S>
  S offset(const ResidualInput<S>& in, std::size_t i) const {
    return in.parameters[term_.residual->parameter_count() + i];
  }
  template <class S>
  void write_rows(const ResidualInput<S>& in, const S* g, S* r) const {
    const S share = share_at(in);
    for (std::size_t i = 0; i < rows_.size(); ++i) r[i] = share * (g[rows_[i]] - offset(in, i));
  }

  ConstraintTerm term_;
  std::vector<int> rows_;  ///< of the constraint
  DurationColumn duration_;
  std::vector<Product> products_;
  std::vector<int> by_duration_;  ///< entry of each row's derivative by the duration
};

}  // namespace

RowsByDuration rows_by_duration(ConstraintKind kind, int rows, const std::vector<double>& lower,
                                const std::vector<double>& upper) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  RowsByDuration made;
  const auto add = [&made](int row, double offset, double low, double high) {
    made.rows.push_back(row);
    made.offsets.push_back(offset);
    made.lower.push_back(low);
    made.upper.push_back(high);
  };
  for (int i = 0; i < rows; ++i) {
    if (kind == ConstraintKind::second_order_cone) {
      made.rows.push_back(i);
      made.offsets.push_back(0);
      continue;
    }
    if (lower[i] == upper[i]) {
      add(i, lower[i], 0, 0);
      continue;
    }
    if (std::isfinite(lower[i])) add(i, lower[i], 0, kNone);
    if (std::isfinite(upper[i])) add(i, upper[i], -kNone, 0);
  }
  return made;
}

ConstraintTerm by_duration(const ConstraintTerm& term, const RowsByDuration& rows,
                           const DurationColumn& duration) {
  if (term.softness != Softness::l1 || term.has_pairs())
    throw std::invalid_argument("constraint " + term.name + ": not soft by its distance");
  if (term.residual->size() + term.rows + term.residual->jacobian_size() + term.jacobian_size() >
      kMostStackNumbers)
    throw std::invalid_argument("constraint " + term.name + ": too large beside a free duration");
  ConstraintTerm made =
      make_constraint(term.name, std::make_shared<ResidualByDuration>(term, rows.rows, duration),
                      term.is_cone() ? term.kind : ConstraintKind::bounds, 1, Softness::l1);
  made.by_duration = true;
  return made;
}

}  // namespace conddp
