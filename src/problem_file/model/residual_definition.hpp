#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "problem_file/model/spec_cost.hpp"
#include "problem_file/yaml/keys.hpp"

namespace conddp {

struct ContactCost;
struct CostResidual;
struct Plant;
struct ProblemSpec;
struct ResidualContext;

/// Context for completing a term.
struct TermContext {
  const ProblemSpec& spec;
  const Plant& plant;
};

/// Restrictions on a key: terms that accept it, and conflicting keys.
struct KeyTraits {
  bool required = false;           ///< by the residuals that have it
  bool of_constraints = true;      ///< constraints accept it
  bool of_last_node = true;        ///< the last node and expressions accept it
  std::string_view excludes = {};  ///< a key that conflicts with it
  std::string_view instead = {};   ///< hint on the alternative in residuals without it
};

/// A key of costs and constraints that only some residuals have.
struct ResidualKey {
  KeyInfo info;
  KeyTraits traits;
  std::function<void(Keys&, const KeyInfo&, CostSpec&)> visit;
  /// Sets the default if it depends on the problem; null: it does not.
  void (*complete)(CostSpec& cost, const TermContext& context) = nullptr;

  bool stands_in(TermPlace place) const {
    const bool running = !place.last_node && place.kind != TermPlace::Kind::kOperand;
    return (traits.of_constraints || place.kind != TermPlace::Kind::kConstraint) &&
           (traits.of_last_node || running);
  }
};

/// A form of references: its syntax and its numbers.
struct ReferenceForm {
  enum class Needed { kNever, kWithoutBarrier, kAlways };

  /// True if the name of a configuration, or 'initial', stands for the value in that state.
  bool of_state = true;
  Needed needed = Needed::kNever;
  bool holds = false;     ///< way-points: each holds until the next one
  bool is_point = false;  ///< a point in the world, m
  /// Reads a reference that is not such a name; empty if an error has been reported.
  std::optional<ReferenceValueSpec> (*read)(const YamlReader& reader, const CostSpec& cost);
  OrderedJson (*expand)(const ReferenceValueSpec& value);
  /// The default reference of a residual; empty if the residual requires one.
  std::optional<ReferenceValueSpec> (*zero)(const CostSpec& cost, const Place& place);
  /// The numbers of a pose; empty if a part is missing, which is reported.
  std::optional<std::vector<double>> (*numbers)(const PoseSpec& pose, Diagnostics& out) = nullptr;
};

/// Requirements of a residual on a problem.
struct ResidualNeeds {
  bool robot = false;
  bool control = false;           ///< of the knot; impulses and the last node lack it
  bool force = false;             ///< of contacts; the last node lacks it
  bool shapes = false;            ///< with pairs to keep apart
  bool previous_control = false;  ///< in the state
  bool chosen_start = false;      ///< an initial state that is optimized
  bool code = false;              ///< permission to run compiled code
};

/// Complete description of a residual of problem files.
struct ResidualDefinition {
  std::string_view name;
  std::string_view description;                 ///< one line
  std::string_view unit;                        ///< of its rows
  std::vector<std::string_view> synonyms = {};  ///< names in other tools
  ResidualNeeds needs = {};
  std::vector<const ResidualKey*> keys = {};  ///< in the order of output
  const ReferenceForm* reference = nullptr;   ///< null: it takes no reference
  bool is_cone = false;                       ///< it has its own bounds, for a barrier
  bool has_limits = false;                    ///< its rows may have limits in the URDF
  /// True if its rows are coordinates of a point, so that constraints can bound its distance.
  bool (*is_point)(const CostSpec& cost) = nullptr;
  /// True if its rows are numbers of the state, positions of joints among them. References are then
  /// compared with joint limits, and guesses can move towards them.
  bool of_positions = false;
  /// Sets the default activation of costs, and values that follow from it; null: quadratic.
  void (*set_activation)(CostSpec& cost) = nullptr;
  /// Makes the residual; empty if it does not fit the plant, which is reported.
  std::optional<CostResidual> (*make)(const ResidualContext& context) = nullptr;
  /// Replaces `make`: makes the residual of one contact, by its number in the file.
  std::optional<ContactCost> (*make_of_contact)(const ResidualContext& context,
                                                int contact) = nullptr;

  /// True if the rows of a cost read residuals of contacts; null: they never do.
  bool (*reads_contacts)(const CostSpec& cost) = nullptr;
  /// Replaces `make` for a cost whose rows read contacts: evaluates all these contacts together.
  std::optional<ContactCost> (*make_on_contacts)(const ResidualContext& context) = nullptr;

  bool of_contacts() const { return make_of_contact != nullptr; }
  bool at_last_node() const { return !needs.control && !needs.force; }
  bool has(std::string_view key) const {
    return std::ranges::any_of(keys, [&](const ResidualKey* own) { return own->info.name == key; });
  }
};

}  // namespace conddp
