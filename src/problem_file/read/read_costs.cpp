#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

ActivationSpec read_activation(const YamlReader& reader) {
  ActivationSpec activation{.place = reader.place()};
  if (reader.is_scalar()) {
    activation.kind = reader.choice(kActivationWords, "activation").value_or(activation.kind);
    if (takes_bounds(activation.kind))
      reader.error("a barrier needs its bounds",
                   "write '{kind: quadratic_barrier, lower: ..., upper: ...}' or 'from: urdf'");
    return activation;
  }
  YamlMap map(reader);
  const auto kind = map.require("kind");
  if (kind)
    activation.kind = kind->choice(kActivationWords, "activation").value_or(activation.kind);
  const auto lower = map.find("lower");
  const auto upper = map.find("upper");
  const auto from = map.find("from");
  if (lower) activation.lower = read_components(*lower);
  if (upper) activation.upper = read_components(*upper);
  if (from) {
    static constexpr Choice<bool> kWords[] = {{"urdf", true}};
    activation.from_urdf = from->choice(kWords, "source of bounds").value_or(false);
  }
  if (takes_bounds(activation.kind)) {
    if (!lower && !upper && !from) reader.error("a barrier needs 'lower', 'upper' or 'from: urdf'");
  } else if (kind) {
    for (const auto& bound : {lower, upper, from})
      if (bound) bound->error("bounds belong to the activation 'quadratic_barrier'");
  }
  if (const auto epsilon = map.find("epsilon")) {
    activation.epsilon = epsilon->number(kPositive).value_or(activation.epsilon);
    if (!takes_epsilon(activation.kind)) epsilon->error("'epsilon' belongs to the smooth norms");
  }
  return activation;
}

std::vector<Located<int>> read_knots(const YamlReader& reader) {
  std::vector<Located<int>> knots;
  if (const auto items = reader.items())
    for (const YamlReader& item : *items)
      if (const auto knot = item.integer(0, 1'000'000)) {
        for (const Located<int>& former : knots)
          if (former.value == *knot) item.error(fmt::format("{} stands twice in the list", *knot));
        knots.push_back({static_cast<int>(*knot), item.place()});
      }
  return knots;
}

SwingSpec read_swing(const YamlReader& reader) {
  SwingSpec swing{.place = reader.place()};
  YamlMap map(reader);
  if (!map.valid()) return swing;
  if (const auto r = map.require("height"))
    swing.height = r->number(kNotNegative).value_or(swing.height);
  map.exclusive({"landing", "step"});
  map.exclusive({"landing", "displaced"});
  map.exclusive({"step", "displaced"});
  if (const auto r = map.find("landing")) swing.landing = read_vector3(*r, "[x, y, z] in m");
  if (const auto r = map.find("step")) swing.step = read_vector3(*r, "[x, y, z] in m");
  if (const auto r = map.find("displaced"))
    if (const auto items = r->items()) {
      for (const YamlReader& item : *items)
        swing.displaced.push_back(read_planar_motion(item).value_or(PlanarMotion{}));
      if (items->empty()) r->error("there is no landing", "write one '[x, y, yaw]' a swing");
    }
  return swing;
}

/// The keys of costs on forces and on feet, which the last node has not.
void read_contact_keys(YamlMap& map, const ResidualInfo& info, bool constraint, CostSpec& cost) {
  const auto unfit = [&](const YamlReader& reader, std::string_view key) {
    reader.error(fmt::format("the residual '{}' has no '{}'", info.name, key));
  };
  if (const auto r = constraint ? std::nullopt : map.find("swing")) {
    cost.swing = read_swing(*r);
    if (info.kind != ResidualKind::kFramePosition && info.kind != ResidualKind::kFramePlacement)
      unfit(*r, "swing");
    map.exclusive({"swing", "reference"});
  }
  const bool friction = info.kind == ResidualKind::kFrictionCone;
  if (const auto r = constraint ? std::nullopt : map.find("cone")) {
    cost.cone.second_order = r->choice(kConeWords, "cone").value_or(false);
    if (!friction) unfit(*r, "cone");
  }
  if (const auto r = map.find("faces")) {
    cost.cone.faces = static_cast<int>(r->integer(3, 64).value_or(cost.cone.faces));
    if (!friction) unfit(*r, "faces");
    if (cost.cone.second_order) r->error("a second-order cone has no faces");
  }
  if (const auto r = map.find("inner")) {
    static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
    cost.cone.inner = r->choice(kWords, "value of 'inner'").value_or(cost.cone.inner);
    if (!friction && info.kind != ResidualKind::kWrenchCone) unfit(*r, "inner");
    if (cost.cone.second_order) r->error("a second-order cone is exact: it has no 'inner'");
  }
  if (const auto r = map.find("safety")) {
    static const NumberRange kFactor{0, 1, true, false, "a factor from 0 (excluded) to 1"};
    cost.cone.safety = r->number(kFactor).value_or(cost.cone.safety);
    if (!friction && info.kind != ResidualKind::kWrenchCone) unfit(*r, "safety");
  }
}

/// One map of factors, or a list of such.
void read_combinations(const YamlReader& reader, CostSpec& cost) {
  if (reader.is_map()) {
    cost.combinations.push_back(read_named_numbers(reader));
    return;
  }
  const auto items = reader.items();
  if (!items) return;
  if (items->empty()) reader.error("there is no row", "write 'rows: [{theta: 1, omega: 0.5}]'");
  for (const YamlReader& item : *items) cost.combinations.push_back(read_named_numbers(item));
}

void read_selection(YamlMap& map, const ResidualInfo& info, CostSpec& cost) {
  const auto unfit = [&](const YamlReader& reader, std::string_view key) {
    reader.error(fmt::format("the residual '{}' has no '{}'", info.name, key));
  };
  if (info.needs_frame) {
    if (const auto r = map.require("frame")) cost.frame = r->name();
  } else if (const auto r = map.find("frame")) {
    unfit(*r, "frame");
  }
  if (const auto r = map.find("joints")) {
    cost.joints = r->name_or_names();
    if (!info.takes_joints) unfit(*r, "joints");
  }
  if (const auto r = map.find("columns")) {
    cost.columns = r->name_or_names();
    if (!info.takes_columns) unfit(*r, "columns");
  }
  if (const auto r = map.find("contacts")) {
    cost.contacts = read_contact_names(*r);
    if (!info.of_contacts) unfit(*r, "contacts");
  }
  if (const auto r = map.find("axes")) {
    cost.axes = r->choice(kAxesWords, "system of axes").value_or(cost.axes);
    if (!info.takes_axes) unfit(*r, "axes");
  }
  if (info.kind == ResidualKind::kCombination) {
    if (const auto r = map.require("rows")) read_combinations(*r, cost);
  } else if (const auto r = map.find("rows")) {
    unfit(*r, "rows");
  }
  if (const auto r = map.find("offset")) {
    cost.offset = read_components(*r);
    if (info.kind != ResidualKind::kCycle) unfit(*r, "offset");
  }
  if (info.of_shapes) {
    if (const auto r = map.require("pairs")) cost.pairs = read_pairs(*r);
  } else if (const auto r = map.find("pairs")) {
    unfit(*r, "pairs");
  }
  if (const auto r = map.find("margin")) {
    cost.margin = r->number(kNotNegative);
    if (!info.of_shapes) unfit(*r, "margin");
    map.exclusive({"margin", "activation"});
  }
}

/// Shapes keep a margin from each other unless an activation says otherwise.
void set_margin(CostSpec& cost) {
  cost.margin = cost.margin.value_or(0);
  cost.activation.kind = ActivationKind::quadratic_barrier;
  cost.activation.place = cost.residual.place;
  cost.activation.lower = {.place = cost.residual.place, .scalar = cost.margin};
}

CostSpec read_cost(const Name& name, const YamlReader& reader, const std::filesystem::path& folder,
                   bool terminal) {
  CostSpec cost{.name = name};
  YamlMap map(reader);
  if (!map.valid() || !read_residual(map, folder, terminal, false, cost)) return cost;
  const ResidualInfo& info = residual_info(cost.kind);
  map.number("weight", cost.weight, kNotNegative);
  if (info.is_cone) cost.activation.kind = ActivationKind::quadratic_barrier;
  if (const auto r = map.find("activation")) {
    if (info.is_cone)
      r->error("a cone has its own bounds, outside of which it costs: it has no activation",
               "leave the key out");
    else
      cost.activation = read_activation(*r);
  }
  if (const auto r = map.find("weights")) cost.weights = read_components(*r, kNotNegative);
  return cost;
}

}  // namespace

bool read_residual(YamlMap& map, const std::filesystem::path& folder, bool terminal,
                   bool constraint, CostSpec& cost) {
  const auto residual = map.require("residual");
  std::vector<std::string> words;
  for (const ResidualInfo& info : residual_table()) words.emplace_back(info.name);
  const auto index = residual ? residual->choose(words, "residual") : std::nullopt;
  if (!index) {
    map.ignore_others();
    return false;
  }
  const ResidualInfo& info = residual_table()[*index];
  cost.kind = info.kind;
  cost.residual = {std::string(info.name), residual->place()};
  read_selection(map, info, cost);
  if (info.of_shapes && !constraint && !map.find("activation")) set_margin(cost);
  if (const auto r = map.find("reference")) {
    if (info.takes_reference)
      cost.reference = read_reference(*r, info.kind, folder);
    else
      r->error(fmt::format("the residual '{}' has no reference", info.name));
  }
  if (terminal) {
    const bool of_forces = info.of_contacts && info.kind != ResidualKind::kContactVelocity;
    if (info.needs_control || of_forces)
      residual->error(fmt::format(
          "the residual '{}' needs a control, and there is none at the terminal node", info.name));
    return true;
  }
  read_contact_keys(map, info, constraint, cost);
  if (const auto r = map.find("phases")) cost.phases = r->name_or_names();
  if (const auto r = map.find("knots")) cost.knots = read_knots(*r);
  return true;
}

std::vector<CostSpec> read_costs(const YamlReader& reader, const std::filesystem::path& folder,
                                 bool terminal) {
  std::vector<CostSpec> costs;
  if (const auto entries = reader.named_entries("write '{effort: {residual: control}}'"))
    for (const auto& [name, value] : *entries)
      costs.push_back(read_cost(name, value, folder, terminal));
  return costs;
}

}  // namespace conddp
