#pragma once

#include <optional>

#include "composed_grid.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Constraint kinds that a solver supports; `auto` supports all.
struct TakenConstraints {
  bool control_bounds = true, equalities = true, inequalities = true;
};

/// Composes costs and constraints of a body on its phases.
class TermComposer {
 public:
  TermComposer(const ComposedBody& body, const ComposedGrid& grid, RandomNumbers& random)
      : body_(body), grid_(grid), random_(random) {}

  /// True if this problem allows the residual on running knots, or at the last node.
  bool can(const ResidualDefinition& residual, bool terminal) const;
  /// Flow mapping of a cost.
  std::string cost(const ResidualDefinition& residual, bool terminal);
  /// Flow mapping of a constraint on a supported residual; hard only if the solver allows it.
  std::string constraint(const ResidualDefinition& residual, bool terminal, Softness softness,
                         const TakenConstraints& taken);
  /// True if the body has this boundable quantity.
  bool can(BoundedQuantity quantity) const;
  /// Flow mapping of bounds on a quantity; hard control bounds are proper bounds.
  std::string bounds(BoundedQuantity quantity, Softness softness);

 private:
  /// Rows (0: unknown) and row names implied by the keys of a residual.
  struct Selection {
    int rows = 0;
    Entries names;
    Entries contacts;  ///< empty: unrelated to contacts, or all contacts
  };
  Selection select(const ResidualDefinition& residual, Entries& keys);
  std::optional<std::string> reference(const ResidualDefinition& residual,
                                       const Selection& selection);
  std::optional<std::string> reference_value(const ResidualDefinition& residual,
                                             const Selection& selection);
  bool has_limits(BoundedQuantity quantity) const;
  void add_places(const ResidualDefinition& residual, bool constraint, Entries& keys);
  void add_set(const ResidualDefinition& residual, const Selection& selection, bool equality,
               Entries& keys);
  void add_activation(const ResidualDefinition& residual, bool referred, Entries& keys);
  Entries running_knots(std::size_t most);
  std::string number(double size) { return number_text(random_.uniform(-size, size)); }

  const ComposedBody& body_;
  const ComposedGrid& grid_;
  RandomNumbers& random_;
};

/// Columns of a body by their names in expressions: `q/knee` is `q[knee]`. Poses have other names.
Entries names_in_expressions(const ComposedBody& body);

/// Adds the keys `soft` and `weight`, unless the constraint is hard.
void add_softness(Softness softness, RandomNumbers& random, Entries& keys);

}  // namespace conddp
