#include "composed_grid.hpp"

#include "problem_file/model/enum_names.hpp"

namespace conddp {
namespace {

void compose_contacts(const ComposedBody& body, RandomNumbers& random, ComposedGrid& grid) {
  std::string lines;
  for (const ComposedBody::Foot& foot : body.feet) {
    ComposedGrid::Contact contact{.name = foot.contact};
    Entries keys = {fmt::format("frame: {}", foot.frame)};
    contact.kind =
        foot.sole && random.chance(0.6) ? ContactKind::surface : pick(kContactWords, random).value;
    if (contact.kind != ContactKind::point || random.chance(0.5))
      keys.push_back("type: " + word_of(kContactWords, contact.kind));
    if (contact.kind == ContactKind::surface) keys.push_back("size: [0.16, 0.08]");
    if (random.chance(0.2)) {
      const auto& axes = pick(kAxesWords, random);
      contact.local = axes.value != FrameAxes::world_aligned;
      keys.push_back(fmt::format("axes: {}", axes.word));
    }
    if (random.chance(0.3)) keys.push_back("normal: [0, 0.1, 1]");
    if (random.chance(0.5))
      keys.push_back(fmt::format("friction: {}", number_text(random.uniform(0.2, 1.2))));
    if (random.chance(0.3)) keys.push_back("min_normal_force: 5, max_normal_force: 2000");
    if (random.chance(0.5))
      keys.push_back(
          fmt::format("baumgarte: {{kp: {}, kd: 20}}", random.chance(0.5) ? "0" : "100"));
    lines += fmt::format("  {}: {}\n", foot.contact, flow_map(keys));
    grid.contacts.push_back(contact);
  }
  if (!lines.empty()) grid.text += "contacts:\n" + lines;
}

void compose_gait(RandomNumbers& random, ComposedGrid& grid) {
  const auto& type = pick(kGaitWords, random);
  Entries keys = {fmt::format("type: {}", type.word), "dt: 0.04"};
  if (type.value != GaitType::stand) {
    keys.push_back("period: 0.32");
    keys.push_back("stand: {begin: 0.04, end: 0.04}");
    keys.push_back(fmt::format("step: {{length: {}, height: 0.03, turn: {}}}",
                               number_text(random.uniform(0, 0.1)),
                               number_text(random.uniform(-0.1, 0.1))));
    if (random.chance(0.2)) keys.push_back("impulses: true");
  }
  grid.text += fmt::format("gait: {}\n", flow_map(keys));
  grid.duration = 0.4;
}

Entries contact_names(const ComposedGrid& grid) {
  Entries names;
  for (const ComposedGrid::Contact& contact : grid.contacts) names.push_back(contact.name);
  return names;
}

/// Adds one entry of `phases`. `held`: its contacts; `even`: all steps have the same length.
void add_phase(int knots, double dt, const Entries& held, bool even, RandomNumbers& random,
               ComposedGrid& grid) {
  ComposedGrid::Phase phase{.name = fmt::format("part_{}", grid.phases.size()),
                            .first = grid.knots(),
                            .knots = knots,
                            .held = held};
  Entries keys = {"name: " + phase.name, fmt::format("knots: {}", knots)};
  const double length = dt * knots;
  keys.push_back(even || random.chance(0.5) ? "dt: " + number_text(dt)
                                            : "duration: " + number_text(length));
  if (!even && knots > 2 && random.chance(0.15))
    keys.push_back("refine: {first: 1, last: 1, ratio: 0.5}");
  if (grid.free_duration)
    keys.push_back(random.chance(0.5) ? "free_duration: {lower: 1.0e-3, upper: 10}"
                                      : "free_duration: {}");
  if (!held.empty())
    keys.push_back("contacts: " + (held == contact_names(grid) ? "all" : flow_list(held)));
  grid.text += fmt::format("  - {}\n", flow_map(keys));
  grid.duration += length;
  grid.phases.push_back(std::move(phase));
}

void add_instant(const std::string& name, const Entries& keys, Entries held, ComposedGrid& grid) {
  Entries all = {"name: " + name};
  all.insert(all.end(), keys.begin(), keys.end());
  grid.text += fmt::format("  - {}\n", flow_map(all));
  grid.phases.push_back(
      {.name = name, .first = grid.knots(), .takes_time = false, .held = std::move(held)});
}

}  // namespace

ComposedGrid compose_grid(const ComposedBody& body, bool smooth, bool bounded,
                          RandomNumbers& random) {
  ComposedGrid grid;
  if (!smooth) compose_contacts(body, random, grid);
  if (body.walks && !smooth && random.chance(0.25)) {
    compose_gait(random, grid);
    return grid;
  }
  grid.text += "phases:\n";
  const Entries all = contact_names(grid);
  grid.choice = random.chance(body.feet.empty() ? 0.25 : 0.1);
  // Choices within bounds are controls with bounds.
  grid.free_duration = grid.choice && bounded && !body.stepping &&
                       body.kind != SystemKind::discrete && random.chance(0.4);
  if (grid.choice) {
    std::string which = grid.free_duration && random.chance(0.5) ? "none" : "all";
    if (which == "all" && !body.columns.empty() && random.chance(0.4))
      which = flow_list(all_in_quotes(pick_some(body.columns, 4, random)));
    Entries keys = {"choose: " + which};
    if (which != "none" && bounded && random.chance(0.5)) keys.push_back("lower: -0.3, upper: 0.5");
    add_instant("start", keys, {}, grid);
  }
  const double dt = between_powers(0.005, 0.1, random);
  const int knots = 2 + random.index(body.most_knots - 1);
  grid.impulse = !all.empty() && random.chance(0.2);
  if (grid.impulse) {
    add_phase(1 + random.index(2), dt, {}, false, random, grid);
    add_instant("hit", {"impulse: all", random.chance(0.5) ? "restitution: 0.3" : "restitution: 0"},
                all, grid);
    add_phase(std::max(1, knots - 2), dt, all, false, random, grid);
    return grid;
  }
  const int parts = knots < 4 ? 1 : 1 + random.index(3);
  for (int left = knots, i = 0; i < parts; ++i) {
    const int own = i + 1 == parts ? left : std::max(1, left / (parts - i));
    Entries held;
    if (!all.empty() && random.chance(0.85))
      held = random.chance(0.6) ? all : pick_some(all, 3, random);
    add_phase(own, dt, held, body.kind == SystemKind::discrete, random, grid);
    left -= own;
  }
  return grid;
}

}  // namespace conddp
