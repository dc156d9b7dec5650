#pragma once

#include <optional>

#include "composed_grid.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// What a solver takes of constraints; `auto` all.
struct TakenConstraints {
  bool control_bounds = true, equalities = true, inequalities = true;
};

/// Composes costs and constraints of a body on its phases.
class TermComposer {
 public:
  TermComposer(const ComposedBody& body, const ComposedGrid& grid, RandomNumbers& random)
      : body_(body), grid_(grid), random_(random) {}

  /// Whether the residual can stand on running knots, or at the last node, of this problem.
  bool can(const ResidualDefinition& residual, bool terminal) const;
  /// The flow mapping of a cost.
  std::string cost(const ResidualDefinition& residual, bool terminal);
  /// That of a constraint on a residual that the solver takes, hard only where it does.
  std::string constraint(const ResidualDefinition& residual, bool terminal, Softness softness,
                         const TakenConstraints& taken);
  /// Whether the body has such a quantity that can be bounded.
  bool can(BoundedQuantity quantity) const;
  /// That of bounds on a quantity; of the control where `softness` is hard as bounds proper.
  std::string bounds(BoundedQuantity quantity, Softness softness);

 private:
  /// What the keys of a residual say of it: how many rows it has (0: not known) and their names.
  struct Selection {
    int rows = 0;
    Entries names;
    Entries contacts;  ///< of which it is, empty: not of contacts, or all
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

/// The keys `soft` and `weight`; none of a hard one.
void add_softness(Softness softness, RandomNumbers& random, Entries& keys);

}  // namespace conddp
