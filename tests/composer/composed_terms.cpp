#include "composed_terms.hpp"

#include "problem_file/model/enum_names.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/values/activation_keys.hpp"

namespace conddp {
namespace {

/// True if the residual requires a reference.
bool needs_reference(const ResidualDefinition& residual) {
  return residual.reference->needed != ReferenceForm::Needed::kNever;
}
constexpr std::string_view kExpression = "expression";
bool is_of_soles(const ResidualDefinition& residual) {
  return residual.name == "wrench_cone" || residual.name == "center_of_pressure";
}
/// Contacts that the residual supports: cones need a normal in the world, pressures need a sole.
auto serves(const ResidualDefinition& residual) {
  return [&residual](const ComposedGrid::Contact& contact) {
    if (is_of_soles(residual)) return contact.kind == ContactKind::surface;
    return residual.name != "friction_cone" || !contact.local;
  };
}

}  // namespace

void add_softness(Softness softness, RandomNumbers& random, Entries& keys) {
  if (softness == Softness::hard) return;
  keys.push_back("soft: " + word_of(kSoftWords, softness));
  keys.push_back("weight: " + number_text(between_powers(0.1, 100, random)));
}

Entries names_in_expressions(const ComposedBody& body) {
  Entries names;
  for (const std::string& column : body.columns) {
    const std::size_t slash = column.find('/');
    const bool several = slash != column.npos && column.find('/', slash + 1) != column.npos;
    if (slash == column.npos)
      names.push_back(column);
    else if (!several && !column.starts_with("base/"))
      names.push_back(column.substr(0, slash) + '[' + column.substr(slash + 1) + ']');
  }
  return names;
}

bool TermComposer::can(const ResidualDefinition& residual, bool terminal) const {
  if (residual.name == "library") return false;  // its function is in a separate file
  if (residual.needs.robot && !body_.robot) return false;
  if (terminal && residual.needs.control) return false;
  if (residual.has("joints") && body_.joints.empty()) return false;
  if (residual.needs.shapes && body_.shapes.empty()) return false;
  if (residual.needs.chosen_start) return grid_.choice;
  if (residual.needs.previous_control) return !grid_.choice && !body_.stepping;
  if (residual.name == kExpression) return !names_in_expressions(body_).empty();
  if (residual.has("rows") && body_.columns.empty()) return false;
  if (!residual.of_contacts()) return true;
  if (terminal)
    return residual.at_last_node() && !grid_.phases.empty() && !grid_.phases.back().held.empty();
  return grid_.holds(serves(residual));
}

TermComposer::Selection TermComposer::select(const ResidualDefinition& residual, Entries& keys) {
  Selection selection;
  if (residual.has("columns") && !body_.columns.empty() && random_.chance(0.5)) {
    selection.names = pick_some(body_.columns, 3, random_);
    keys.push_back("columns: " + flow_list(all_in_quotes(selection.names)));
  }
  if (residual.has("joints")) {
    selection.names = body_.joints;
    if (random_.chance(0.5)) {
      selection.names = pick_some(body_.joints, 3, random_);
      keys.push_back("joints: " + flow_list(all_in_quotes(selection.names)));
    }
  }
  if (residual.name == "control") selection.names = body_.controls;
  selection.rows = static_cast<int>(selection.names.size());
  if (residual.has("frame")) keys.push_back("frame: " + in_quotes(pick(body_.frames, random_)));
  if (residual.has("axes") && random_.chance(0.5))
    keys.push_back("axes: " + pick_word(kAxesWords, random_));
  if (residual.needs.shapes) {
    const bool named = random_.chance(0.4);
    keys.push_back("pairs: " + (named ? fmt::format("[[{}, {}]]", body_.shapes[0], body_.shapes[2])
                                      : pick_word(kPairsWords, random_)));
  }
  if (residual.of_contacts()) {
    const auto fits = serves(residual);
    for (const ComposedGrid::Contact& contact : grid_.contacts)
      if (fits(contact)) selection.contacts.push_back(contact.name);
    if (selection.contacts.size() < grid_.contacts.size() || random_.chance(0.3))
      keys.push_back("contacts: " + flow_list(selection.contacts));
  }
  if (residual.name == kExpression) {
    const Entries names = names_in_expressions(body_);
    Entries rows;
    for (int i = random_.index(2); i >= 0; --i)
      rows.push_back(in_quotes(
          fmt::format("{}*{} + sin({})", number(2), pick(names, random_), pick(names, random_))));
    selection.rows = static_cast<int>(rows.size());
    keys.push_back("rows: " + flow_list(rows));
  } else if (residual.has("rows")) {
    Entries rows;
    for (int i = random_.index(2); i >= 0; --i) {
      Entries row;
      for (const std::string& name : pick_some(body_.columns, 2, random_))
        row.push_back(in_quotes(name) + ": " + number(2));
      if (random_.chance(0.5)) row.push_back("constant: " + number(0.3));
      rows.push_back(flow_map(row));
    }
    selection.rows = static_cast<int>(rows.size());
    keys.push_back("rows: " + flow_list(rows));
  }
  if (residual.needs.chosen_start && !body_.columns.empty() && random_.chance(0.4))
    keys.push_back(
        fmt::format("offset: {{{}: {}}}", in_quotes(pick(body_.columns, random_)), number(0.3)));
  return selection;
}

std::optional<std::string> TermComposer::reference_value(const ResidualDefinition& residual,
                                                         const Selection& selection) {
  const auto three = [&] { return flow_list(random_numbers(3, 0.6, random_)); };
  const ReferenceForm* form = residual.reference;
  if (residual.name == kExpression) return flow_list(random_numbers(selection.rows, 0.6, random_));
  if (form == &kStateReference) {
    if (!selection.names.empty()) return flow_list(random_numbers(selection.rows, 0.6, random_));
    if (body_.columns.empty() || random_.chance(0.4)) return "initial";
    Entries values;
    for (const std::string& column : pick_some(body_.columns, 6, random_))
      values.push_back(in_quotes(column) + ": " + number(0.8));
    return fmt::format("{{values: {}}}", flow_map(values));
  }
  if (residual.name == "contact_force" || residual.name == "centroidal_momentum") return number(3);
  if (form == &kNumbersReference || form == &kControlReference) {
    if (selection.rows == 0 || random_.chance(0.4)) return number(0.8);
    return flow_list(random_numbers(selection.rows, 0.8, random_));
  }
  if (form == &kTwistReference) return fmt::format("{{linear: {}}}", three());
  if (random_.chance(0.5)) return "initial";
  if (form == &kPointReference) return three();
  if (form == &kRotationReference) return fmt::format("{{rpy: {}}}", three());
  return fmt::format("{{position: {}, rpy: {}}}", three(), three());
}

std::optional<std::string> TermComposer::reference(const ResidualDefinition& residual,
                                                   const Selection& selection) {
  if (residual.reference == nullptr) return std::nullopt;
  if (!needs_reference(residual) && random_.chance(0.5)) return std::nullopt;
  if (random_.chance(0.8) || grid_.duration == 0) return reference_value(residual, selection);
  const auto first = reference_value(residual, selection),
             last = reference_value(residual, selection);
  return fmt::format("{{times: [0, {}], values: [{}, {}]}}", number_text(grid_.duration), *first,
                     *last);
}

Entries TermComposer::running_knots(std::size_t most) {
  Entries all;
  for (const ComposedGrid::Phase& phase : grid_.phases)
    for (int k = std::max(phase.first, 1); phase.takes_time && k < phase.first + phase.knots; ++k)
      all.push_back(std::to_string(k));
  return all.empty() ? all : pick_some(all, most, random_);
}

void TermComposer::add_places(const ResidualDefinition& residual, bool constraint, Entries& keys) {
  // A constraint at knot 0 is hopeless unless the control of that knot moves it.
  if (random_.chance(constraint && !residual.needs.control ? 0.8 : 0.15)) {
    if (const Entries knots = running_knots(4); !knots.empty()) {
      keys.push_back("knots: " + flow_list(knots));
      return;
    }
  }
  if (!random_.chance(0.2)) return;
  Entries names;
  for (const ComposedGrid::Phase& phase : grid_.phases)
    if (phase.takes_time) names.push_back(phase.name);
  if (names.empty()) return;
  const std::string name = pick(names, random_);
  if (grid_.impulse && !residual.needs.control && !body_.curved && random_.chance(0.5))
    keys.push_back(fmt::format("phases: [{}, hit]", name));
  else
    keys.push_back("phases: " + (random_.chance(0.3) ? in_quotes("part_*") : name));
}

void TermComposer::add_activation(const ResidualDefinition& residual, bool referred,
                                  Entries& keys) {
  if (residual.is_cone) return;
  if (residual.needs.shapes && random_.chance(0.5)) {
    keys.push_back("margin: " + number_text(random_.uniform(0, 0.2)));
    return;
  }
  if (random_.chance(0.5)) return;
  const auto& activation = pick(kActivationWords, random_);
  Entries own = {fmt::format("kind: {}", activation.word)};
  if (activation.value == ActivationKind::quadratic_barrier) {
    if (body_.robot && !referred && residual.has_limits && random_.chance(0.4) &&
        std::none_of(keys.begin(), keys.end(),
                     [](const std::string& key) { return key.starts_with("columns"); }))
      own.push_back("from: urdf");
    else
      own.push_back(fmt::format("lower: {}, upper: {}", number_text(-random_.uniform(0, 1)),
                                number_text(random_.uniform(0, 1))));
  } else if (!has_keys(activation.value) || random_.chance(0.5)) {
    keys.push_back(fmt::format("activation: {}", activation.word));
    return;
  } else {
    own.push_back("epsilon: " + number_text(between_powers(1e-3, 1, random_)));
  }
  keys.push_back("activation: " + flow_map(own));
}

std::string TermComposer::cost(const ResidualDefinition& residual, bool terminal) {
  Entries keys = {fmt::format("residual: {}", residual.name)};
  const Selection selection = select(residual, keys);
  const auto referred = reference(residual, selection);
  const bool limits_alone = !referred;
  if (referred) keys.push_back("reference: " + *referred);
  add_activation(residual, !limits_alone, keys);
  keys.push_back("weight: " + number_text(between_powers(1e-3, 1e3, random_)));
  if (random_.chance(0.25)) {
    const std::string weight = number_text(between_powers(0.1, 10, random_));
    keys.push_back(
        "weights: " +
        (selection.names.empty() || random_.chance(0.3)
             ? fmt::format("{{\"*\": {}}}", weight)
             : fmt::format("{{{}: {}}}", in_quotes(pick(selection.names, random_)), weight)));
  }
  if (residual.has("cone") && random_.chance(0.6)) {
    const auto& cone = pick(kConeWords, random_);
    keys.push_back(fmt::format("cone: {}", cone.word));
    if (!cone.value)
      keys.push_back(
          fmt::format("faces: {}, inner: {}", 3 + random_.index(6), random_.chance(0.5)));
    keys.push_back("safety: 0.9");
  }
  if (!terminal) add_places(residual, false, keys);
  return flow_map(keys);
}

void TermComposer::add_set(const ResidualDefinition& residual, const Selection& selection,
                           bool equality, Entries& keys) {
  if (residual.is_cone) {
    if (residual.has("cone") && random_.chance(0.5)) keys.push_back("cone: second_order");
    return;
  }
  const double size = between_powers(0.05, 10, random_);
  const auto positive = [&] { return number_text(random_.uniform(0, size)); };
  if (equality) {
    if (residual.needs.shapes)
      keys.push_back("equals: " + positive());
    else if (!selection.names.empty() && random_.chance(0.5))
      keys.push_back(fmt::format("equals: {{{}: {}}}", in_quotes(pick(selection.names, random_)),
                                 number(0.2)));
    else if (random_.chance(0.3))
      keys.push_back("equals: " + number(0.2));
    return;
  }
  switch (random_.index(5)) {
    case 0:
      keys.push_back(fmt::format("lower: -{}", positive()));
      return;
    case 1:
      keys.push_back("at_most: " + positive());
      if (random_.chance(0.2)) keys.push_back("at_least: 0");
      return;
    case 2:
      if (!residual.needs.shapes && !residual.needs.chosen_start &&
          residual.name != "contact_velocity" &&
          (selection.rows >= 2 || residual.has("frame") || residual.name == "contact_force")) {
        keys.push_back("cone: second_order");
        if (!residual.of_contacts() && random_.chance(0.5))
          keys.push_back("slope: " + number_text(random_.uniform(0.2, 3)));
        return;
      }
      [[fallthrough]];
    case 3:
      if (residual.name != "contact_velocity" && random_.chance(0.5)) {
        keys.push_back("at_least: " + number_text(0.1 * random_.uniform(0, size)));
        return;
      }
      [[fallthrough]];
    default:
      keys.push_back(fmt::format("lower: -{}, upper: {}", positive(), positive()));
  }
}

std::string TermComposer::constraint(const ResidualDefinition& residual, bool terminal,
                                     Softness softness, const TakenConstraints& taken) {
  Entries keys = {fmt::format("residual: {}", residual.name)};
  const Selection selection = select(residual, keys);
  const bool equality = softness == Softness::hard && (!taken.inequalities || random_.chance(0.3));
  const bool point =
      residual.is_point != nullptr &&
      (residual.name == "control" || residual.name == "state" ? selection.rows > 0 : true);
  if (point && !equality && random_.chance(0.25)) {
    const std::size_t n = selection.rows > 0 ? selection.rows : 3;
    keys.push_back(fmt::format("centers: [{}, {}]", flow_list(random_numbers(n, 1, random_)),
                               flow_list(random_numbers(n, 1, random_))));
    keys.push_back("at_least: " + number_text(random_.uniform(0.01, 0.3)));
  } else {
    if (const auto referred = reference(residual, selection))
      keys.push_back("reference: " + *referred);
    add_set(residual, selection, equality, keys);
  }
  add_softness(softness, random_, keys);
  if (!terminal) add_places(residual, true, keys);
  return flow_map(keys);
}

bool TermComposer::can(BoundedQuantity quantity) const {
  if (quantity == BoundedQuantity::kControl) return true;
  if (quantity == BoundedQuantity::kState) return !body_.columns.empty();
  return body_.kind == SystemKind::second_order &&
         (quantity == BoundedQuantity::kVelocity ? body_.velocities : body_.positions);
}

bool TermComposer::has_limits(BoundedQuantity quantity) const {
  if (quantity == BoundedQuantity::kControl) return body_.robot;
  const bool positions = quantity != BoundedQuantity::kVelocity;
  const bool velocities = quantity != BoundedQuantity::kConfiguration;
  return (positions && body_.limited_positions) || (velocities && body_.limited_velocities);
}

std::string TermComposer::bounds(BoundedQuantity quantity, Softness softness) {
  Entries keys = {"bounds: " + word_of(kBoundedWords, quantity)};
  const bool urdf = has_limits(quantity) && random_.chance(0.3);
  const double size = between_powers(quantity == BoundedQuantity::kControl ? 0.5 : 2, 50, random_);
  if (urdf) {
    keys.push_back("from: urdf");
    if (random_.chance(0.4)) keys.push_back("scale: " + number_text(random_.uniform(1, 2)));
  } else {
    if (random_.chance(0.8)) keys.push_back("lower: " + number_text(-size));
    if (keys.size() == 1 || random_.chance(0.8)) keys.push_back("upper: " + number_text(size));
  }
  add_softness(softness, random_, keys);
  if (!grid_.phases.empty() && random_.chance(0.2))
    keys.push_back("phases: " + in_quotes("part_*"));
  return flow_map(keys);
}

}  // namespace conddp
