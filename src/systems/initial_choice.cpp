#include "systems/initial_choice.hpp"

#include "systems/closed_form.hpp"

namespace conddp {
namespace {

class InitialChoice : public ClosedFormSystem<InitialChoice> {
 public:
  InitialChoice(const System& of, const std::vector<int>& coordinates, std::vector<Column> controls,
                std::vector<std::pair<int, int>> moved)
      : ClosedFormSystem(SystemKind::first_order, of.manifold(), static_cast<int>(controls.size())),
        moved_(std::move(moved)) {
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      moved_.emplace_back(coordinates[i], static_cast<int>(i));
    state_columns_ = of.state_columns();
    for (int i = 0; i < nx(); ++i) at_rest_.push_back(!of.has_state(i));
    control_columns_ = std::move(controls);
  }

  bool is_linear() const override { return true; }

  template <class S>
  void rate(const S*, const S* u, S* f) const {
    for (int i = 0; i < ndx(); ++i) f[i] = S(0.0);
    for (const auto& [coordinate, control] : moved_) f[coordinate] = u[control];
  }

 private:
  std::vector<std::pair<int, int>> moved_;  ///< (coordinate, control)
};

}  // namespace

std::shared_ptr<const System> initial_choice(const System& of, const std::vector<int>& coordinates,
                                             const std::vector<Column>& controls,
                                             const std::vector<std::pair<int, int>>& moved) {
  return std::make_shared<InitialChoice>(of, coordinates, controls, moved);
}

std::vector<int> chosen_coordinates(const System& choice) {
  const auto data = choice.create_data(double{});
  const std::vector<double> x = choice.manifold().neutral(), u(choice.nu(), 1.0);
  choice.evaluate(x.data(), u.data(), *data);
  std::vector<int> chosen;
  for (int i = 0; i < choice.ndx(); ++i)
    if (data->f[i] != 0) chosen.push_back(i);
  return chosen;
}

}  // namespace conddp
