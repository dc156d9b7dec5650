#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/spec/spec_cost.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

struct ContactCost;
struct CostResidual;
struct Plant;
struct ProblemSpec;
struct ResidualContext;

/// Where a residual stands: in a cost or a constraint, on running knots or at the last node.
struct TermPlace {
  bool constraint = false;
  bool last_node = false;
};

/// What the expansion of a key needs to know.
struct KeyContext {
  const ProblemSpec& spec;
  const Plant& plant;
  TermPlace place;
};

/// Where a key of residuals can stand, and beside what.
struct KeyTraits {
  bool required = false;       ///< by the residuals that have it
  bool of_constraints = true;  ///< whether constraints have it, too
  bool of_last_node = true;
  std::string_view excludes = {};  ///< a key that cannot stand beside it
  std::string_view instead = {};   ///< of residuals without it: what selects or says the same
};

/// A key of costs and constraints that belongs to some residuals.
struct ResidualKey {
  std::string_view name;
  std::string_view description;  ///< one line, with the unit
  OrderedJson schema;            ///< of its value: JSON Schema, with default and examples
  KeyTraits traits;
  /// Into the cost's keys.
  std::function<void(const YamlReader&, CostSpec&)> read;
  /// What the reader would read the same from, or its fallback; null: left out.
  std::function<OrderedJson(const CostSpec&, const KeyContext&)> expand;

  bool stands_in(TermPlace place) const {
    return (traits.of_constraints || !place.constraint) &&
           (traits.of_last_node || !place.last_node);
  }
};

/// A form of references: how one is written, and in which numbers it is given.
struct ReferenceForm {
  enum class Needed { kNever, kWithoutBarrier, kAlways };

  /// Whether the name of a configuration, or 'initial', stands for the value in that state.
  bool of_state = true;
  Needed needed = Needed::kNever;
  bool holds = false;     ///< of way-points: each counts until the next one
  bool is_point = false;  ///< of the world, m
  /// What is no such name; nothing where that has been reported.
  std::optional<ReferenceValueSpec> (*read)(const YamlReader& reader, const CostSpec& cost);
  OrderedJson (*expand)(const ReferenceValueSpec& value);
  /// What a residual is measured from that has no reference; nothing where it needs one.
  std::optional<ReferenceValueSpec> (*zero)(const CostSpec& cost, const Place& place);
  /// The numbers of a pose; nothing where it lacks one, which is reported.
  std::optional<std::vector<double>> (*numbers)(const PoseSpec& pose, Diagnostics& out) = nullptr;
};

/// What a residual has to find in a problem.
struct ResidualNeeds {
  bool robot = false;
  bool control = false;           ///< of the knot: there is none at impulses and at the last node
  bool force = false;             ///< of contacts: there is none at the last node
  bool shapes = false;            ///< that must keep apart
  bool previous_control = false;  ///< in the state
  bool chosen_start = false;      ///< a first state that is chosen
  bool code = false;              ///< compiled code that may be run
};

/// All that the program knows of a residual of problem files.
struct ResidualDefinition {
  std::string_view name;
  std::string_view description;                 ///< one line
  std::string_view unit;                        ///< of its rows
  std::vector<std::string_view> synonyms = {};  ///< what other tools call it
  ResidualNeeds needs = {};
  std::vector<const ResidualKey*> keys = {};  ///< in the order in which they are written
  const ReferenceForm* reference = nullptr;   ///< null: it has none
  bool is_cone = false;                       ///< comes with its own bounds, for a barrier
  bool has_limits = false;                    ///< its rows may have limits in the URDF
  /// Whether its rows are coordinates of a point, from which constraints can be at a distance.
  bool (*is_point)(const CostSpec& cost) = nullptr;
  /// Whether its rows are numbers of the state, positions of joints among them: references are
  /// compared with the limits of joints, and guesses can go towards them.
  bool of_positions = false;
  /// The activation of costs that give none, with other values that follow from it; null:
  /// quadratic.
  void (*set_activation)(CostSpec& cost) = nullptr;
  /// The residual, or nothing if it does not fit the plant, which is reported.
  std::optional<CostResidual> (*make)(const ResidualContext& context) = nullptr;
  /// Instead of `make`: the residual of one of the contacts, by its number in the file.
  std::optional<ContactCost> (*make_of_contact)(const ResidualContext& context,
                                                int contact) = nullptr;

  /// Whether the rows of a cost read residuals of contacts; null: they never do.
  bool (*reads_contacts)(const CostSpec& cost) = nullptr;
  /// Instead of `make`, of a cost whose rows do: on all these contacts at once.
  std::optional<ContactCost> (*make_on_contacts)(const ResidualContext& context) = nullptr;

  bool of_contacts() const { return make_of_contact != nullptr; }
  bool at_last_node() const { return !needs.control && !needs.force; }
  bool has(std::string_view key) const;
};

}  // namespace conddp
